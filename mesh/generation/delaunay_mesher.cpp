#include "mesh/generation/delaunay_mesher.h"

#include "mesh/generation/cell_labels.h"

#include <CGAL/Exact_predicates_inexact_constructions_kernel.h>
#include <CGAL/Labeled_mesh_domain_3.h>
#include <CGAL/Mesh_complex_3_in_triangulation_3.h>
#include <CGAL/Mesh_criteria_3.h>
#include <CGAL/Mesh_triangulation_3.h>
#include <CGAL/Random.h>
#include <CGAL/refine_mesh_3.h>

// This header comes last because it relies on the includes of the others.
#include <CGAL/exude_mesh_3.h>

#include <unordered_map>

namespace retractor::mesh {

namespace {

    namespace params = CGAL::parameters;
    using Kernel = CGAL::Exact_predicates_inexact_constructions_kernel;
    using Domain = CGAL::Labeled_mesh_domain_3<Kernel>;
    using Point = Domain::Point_3;
    using Index = Domain::Index;

    // Circumradius over edge length: 0.577 for an equilateral triangle, 0.612 for a regular tetrahedron. Refinement
    // ends with radii below its bounds; these factors make the mean edge equal to the wanted edge.
    constexpr double kFacetRadiusPerEdge = 0.75;
    constexpr double kCellRadiusPerEdge = 0.85;
    constexpr double kFacetAngle = 25.0; ///< degrees; refinement is proven to end for angles up to 30
    constexpr double kCellRadiusEdgeRatio = 2.5; ///< circumradius over shortest edge
    constexpr double kSliverBound = 12.0; ///< degrees; exudation works on tetrahedra with a smaller angle
    constexpr double kSurfaceTolerance = 0.02; ///< mm; tolerance of bisection on the label function

    struct Cancelled { };

    Vec3 vec(const Point& p) { return { p.x(), p.y(), p.z() }; }

    /// Label function for CGAL. A cancelled refinement is stopped here.
    class LabelFunction {
    public:
        LabelFunction(const LabelField& field, const Job& job)
            : field_(field)
            , job_(job)
        {
        }
        int operator()(const Point& p) const
        {
            if (job_.cancelled())
                throw Cancelled {};
            return field_.at(vec(p));
        }

    private:
        const LabelField& field_;
        const Job& job_;
    };

    /// The two labels of a surface patch, or one label and 0.
    std::pair<int, int> labels_of(const Index& index)
    {
        if (const auto* patch = boost::get<Domain::Surface_patch_index>(&index))
            return *patch;
        return { boost::get<Domain::Subdomain_index>(index), 0 };
    }

    /// Sizing field in CGAL's form.
    template <class Value> struct Field {
        using FT = Kernel::FT;
        using Point_3 = Point;
        using Index = Domain::Index;
        Value value;
        FT operator()(const Point_3& p, int /*dimension*/, const Index& index) const
        {
            const auto [a, b] = labels_of(index);
            return value(vec(p), a, b);
        }
    };
    template <class Value> Field(Value) -> Field<Value>;

    template <class Complex>
    void insert_seeds(Complex& complex, const Domain& domain, std::span<const SurfaceSeed> seeds)
    {
        for (const SurfaceSeed& seed : seeds) {
            const Point p(seed.point.x(), seed.point.y(), seed.point.z());
            const auto vertex = complex.triangulation().insert(typename Complex::Triangulation::Weighted_point(p));
            if (vertex == typename Complex::Vertex_handle())
                continue;
            complex.set_dimension(vertex, 2);
            complex.set_index(vertex, domain.index_from_surface_patch_index({ seed.a, seed.b }));
        }
    }

    /// Every finite cell of the triangulation, cells outside the body included.
    template <class Complex> LabelledCells copy_cells(const Complex& complex)
    {
        LabelledCells cells;
        const auto& triangulation = complex.triangulation();
        std::unordered_map<typename Complex::Vertex_handle, VertexId> vertex_number;
        for (auto vertex : triangulation.finite_vertex_handles()) {
            vertex_number.emplace(vertex, static_cast<VertexId>(cells.vertices.size()));
            cells.vertices.push_back(vec(vertex->point().point()));
        }
        std::unordered_map<typename Complex::Cell_handle, TetId> cell_number;
        for (auto cell : triangulation.finite_cell_handles())
            cell_number.emplace(cell, static_cast<TetId>(cell_number.size()));
        for (auto cell : triangulation.finite_cell_handles()) {
            auto& tet = cells.tets.emplace_back();
            auto& beside = cells.neighbours.emplace_back();
            for (int i = 0; i < 4; ++i) {
                tet[static_cast<std::size_t>(i)] = vertex_number.at(cell->vertex(i));
                const auto found = cell_number.find(cell->neighbor(i));
                beside[static_cast<std::size_t>(i)] = found == cell_number.end() ? -1 : found->second;
            }
            cells.labels.push_back(static_cast<std::uint8_t>(complex.subdomain_index(cell)));
        }
        return cells;
    }

    /// The cells that belong to the body.
    void copy_mesh(const LabelledCells& cells, LocalMesh& mesh)
    {
        std::vector<VertexId> number(cells.vertices.size(), -1);
        for (std::size_t c = 0; c < cells.tets.size(); ++c) {
            if (cells.labels[c] == 0)
                continue;
            std::array<VertexId, 4> tet = cells.tets[c];
            for (VertexId& v : tet) {
                VertexId& n = number[static_cast<std::size_t>(v)];
                if (n < 0) {
                    n = static_cast<VertexId>(mesh.vertices.size());
                    mesh.vertices.push_back(cells.vertices[static_cast<std::size_t>(v)]);
                }
                v = n;
            }
            mesh.tets.push_back(tet);
            mesh.labels.push_back(cells.labels[c]);
        }
    }

    template <class ConcurrencyTag>
    void build(const LabelField& field, const SizeField& size, std::span<const SurfaceSeed> seeds, const Job& job,
        LocalMesh& mesh)
    {
        using Triangulation = typename CGAL::Mesh_triangulation_3<Domain, CGAL::Default, ConcurrencyTag>::type;
        using Complex = CGAL::Mesh_complex_3_in_triangulation_3<Triangulation>;
        using Criteria = CGAL::Mesh_criteria_3<Triangulation>;

        // Random numbers start from a fixed seed, and CGAL's global generator is reset, so that every call in a process
        // gives the same mesh.
        CGAL::Random random(0);
        CGAL::get_default_random() = CGAL::Random(0);
        const Vec3 low = field.lower(), high = field.upper();
        const Domain domain(LabelFunction(field, job), CGAL::Bbox_3(low[0], low[1], low[2], high[0], high[1], high[2]),
            2.0 * kSurfaceTolerance / (high - low).norm(), params::p_rng = &random);
        const Criteria criteria(params::facet_angle = kFacetAngle,
            params::facet_size
            = Field { [&](const Vec3& p, int a, int b) { return kFacetRadiusPerEdge * size.edge(p, a, b); } },
            params::facet_distance
            = Field { [&](const Vec3& p, int a, int b) { return size.facet_distance(p, a, b); } },
            params::cell_radius_edge_ratio = kCellRadiusEdgeRatio,
            params::cell_size
            = Field { [&](const Vec3& p, int a, int b) { return kCellRadiusPerEdge * size.edge(p, a, b); } });

        Stopwatch watch;
        Complex complex;
        insert_seeds(complex, domain, seeds);
        CGAL::refine_mesh_3(
            complex, domain, criteria, params::no_perturb(), params::no_exude(), params::no_reset_c3t3());
        mesh.refine_seconds = watch.seconds();
        if (job.cancelled())
            throw Cancelled {};

        // Only exudation: perturbation gains little before the polish of mesh/generation/mesh_polish.h, and takes
        // between a fifth and twenty times the time of refinement.
        job.report("optimise tetrahedra", 0.0);
        watch = Stopwatch();
        CGAL::exude_mesh_3(complex, params::sliver_bound = kSliverBound, params::time_limit = 0);
        LabelledCells cells = copy_cells(complex);
        fit_labels(cells, field);
        copy_mesh(cells, mesh);
        mesh.optimise_seconds = watch.seconds();
    }

} // namespace

LocalMesh delaunay_mesh(
    const LabelField& field, const SizeField& size, std::span<const SurfaceSeed> seeds, bool parallel, const Job& job)
{
    LocalMesh mesh;
    try {
        if (parallel)
            build<CGAL::Parallel_if_available_tag>(field, size, seeds, job, mesh);
        else
            build<CGAL::Sequential_tag>(field, size, seeds, job, mesh);
    } catch (const Cancelled&) {
        mesh = {};
        mesh.cancelled = true;
    }
    return mesh;
}

} // namespace retractor::mesh
