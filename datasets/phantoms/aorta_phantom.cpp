#include "datasets/phantoms/aorta_phantom.h"

#include "mesh/base/error.h"

#include <Eigen/Geometry>

#include <array>
#include <cmath>
#include <numbers>

namespace retractor::datasets {

namespace {

    constexpr Label kNormal = 1, kSclerotic = 2;
    constexpr double kPi = std::numbers::pi;
    constexpr double kAscending = 45.0, kArchRadius = 35.0, kDescending = 65.0; ///< mm
    constexpr double kArch = kPi * kArchRadius;

    /// A point of the centreline, and the unit directions across the centreline.
    struct Frame {
        /// `outer` points away from the middle of the arch; outer x side points along the centreline.
        Vec3 point, outer, side;
    };

    Frame arch_frame(double s)
    {
        const Vec3 across = Vec3(0.55, 0.83, 0.0).normalized(); // to the left and back, like an arch in a body
        const Vec3 up = Vec3::UnitZ();
        const double angle = std::clamp((s - kAscending) / kArchRadius, 0.0, kPi);
        const Vec3 outer = -std::cos(angle) * across + std::sin(angle) * up;
        const Vec3 along = std::sin(angle) * across + std::cos(angle) * up;
        Vec3 point = kArchRadius * across + kArchRadius * outer;
        point += up * (s < kAscending ? s - kAscending : 0.0);
        point -= up * (s > kAscending + kArch ? s - kAscending - kArch : 0.0);
        return { point, outer, along.cross(outer) };
    }

    Frame tube_frame(double s) { return { { 0.0, 0.0, s }, Vec3::UnitX(), Vec3::UnitY() }; }

    struct Sweep {
        const AortaParameters& p;
        double length;
        double region_middle;
        double site_angle; ///< angle about the vessel, from `outer` (radians)

        explicit Sweep(const AortaParameters& parameters)
            : p(parameters)
        {
            const bool arch = p.shape == AortaParameters::Shape::arch;
            length = arch ? kAscending + kArch + kDescending : p.length_mm;
            region_middle = arch ? kAscending + 0.75 * kArch : 0.5 * length;
            site_angle = arch ? 0.5 * kPi : 0.0;
        }
        Frame frame(double s) const { return p.shape == AortaParameters::Shape::arch ? arch_frame(s) : tube_frame(s); }
        Vec3 place(double s, double angle, double radius) const
        {
            const Frame f = frame(s);
            return f.point + radius * (std::cos(angle) * f.outer + std::sin(angle) * f.side);
        }
        /// True where the branch vessels leave the arch and hold the wall.
        bool branches(double s, double angle) const
        {
            constexpr double kHalfLength = 15.0, kHalfAngle = 40.0 * kPi / 180.0; // mm
            return p.shape == AortaParameters::Shape::arch && std::abs(s - kAscending - 0.5 * kArch) <= kHalfLength
                && std::abs(std::remainder(angle, 2.0 * kPi)) <= kHalfAngle;
        }
        bool sclerotic(double s, double angle) const
        {
            constexpr double kRound = 1e-9; // an element on the border counts as inside
            const double half_turn = std::abs(std::remainder(angle - site_angle, 2.0 * kPi)) * 180.0 / kPi;
            return p.region.length_mm > 0.0 && std::abs(s - region_middle) <= 0.5 * p.region.length_mm + kRound
                && half_turn <= 0.5 * p.region.angle_deg + kRound;
        }
    };

    void check(const AortaParameters& p)
    {
        const auto refuse = [](const char* what, const char* where) { throw InputError(what, where); };
        if (!(p.inner_radius_mm > 0.0 && p.outer_radius_mm > p.inner_radius_mm && p.outer_radius_mm < kArchRadius))
            refuse("0 < inner radius < outer radius < 35 mm is needed", "radius");
        if (!(std::isfinite(p.length_mm) && p.length_mm > 0.0))
            refuse("must be positive", "length");
        if (!(p.region.length_mm >= 0.0 && std::isfinite(p.region.length_mm)))
            refuse("the length of the region must not be negative", "region");
        if (!(p.region.angle_deg > 0.0 && p.region.angle_deg <= 360.0))
            refuse("the angle of the region lies between 0 and 360 degrees", "region");
        if (p.around < 6 || p.through < 1 || p.along < 2)
            refuse("at least 6 elements around, 1 through the wall and 2 along are needed", "elements");
        if (static_cast<double>(p.around) * p.through * p.along > 2e6)
            refuse("more than 12 million elements", "elements");
        if (p.nodes_per_tet != 4 && p.nodes_per_tet != 10)
            refuse("elements have 4 or 10 nodes", "nodes");
    }

    /// The grid before bending, in the parameters angle step, layer and length step.
    struct Grid {
        mesh::TetMesh mesh;
        std::vector<std::array<double, 3>> place; ///< parameters of each node; the angle step is periodic with `around`
    };

    /// Kuhn's six tetrahedra are the same in every cell, so the grid closes on itself.
    mesh::TetMesh kuhn_ring(const AortaParameters& p)
    {
        mesh::TetMesh mesh;
        const auto id = [&](int i, int j, int k) {
            return static_cast<VertexId>((k * (p.through + 1) + j) * p.around + i % p.around);
        };
        mesh.vertices.resize(static_cast<Eigen::Index>(p.along + 1) * (p.through + 1) * p.around, 3);
        for (int k = 0; k <= p.along; ++k)
            for (int j = 0; j <= p.through; ++j)
                for (int i = 0; i < p.around; ++i)
                    mesh.vertices.row(id(i, j, k)) << i, j, k;
        constexpr std::array<std::array<int, 3>, 6> kOrders { { { 0, 1, 2 }, { 1, 2, 0 }, { 2, 0, 1 }, { 0, 2, 1 },
            { 2, 1, 0 }, { 1, 0, 2 } } };
        for (int k = 0; k < p.along; ++k)
            for (int j = 0; j < p.through; ++j)
                for (int i = 0; i < p.around; ++i)
                    for (std::size_t o = 0; o < kOrders.size(); ++o) {
                        std::array<int, 3> at { i, j, k };
                        std::array<VertexId, 4> tet { id(at[0], at[1], at[2]) };
                        for (std::size_t step = 0; step < 3; ++step) {
                            ++at[static_cast<std::size_t>(kOrders[o][step])];
                            tet[step + 1] = id(at[0], at[1], at[2]);
                        }
                        // The axes (angle, outwards, along) are left-handed, so the first three orders give inverted
                        // tetrahedra.
                        if (o < 3)
                            std::swap(tet[2], tet[3]);
                        mesh.nodes.insert(mesh.nodes.end(), tet.begin(), tet.end());
                        mesh.labels.push_back(kNormal);
                    }
        return mesh;
    }

    /// The parameters of an element's corners, with neighbouring angle steps: corners beyond the seam get `around` more
    /// steps.
    std::array<std::array<double, 3>, 4> unrolled(const mesh::TetMesh& grid, TetId t, int around)
    {
        std::array<std::array<double, 3>, 4> corners {};
        bool far = false;
        for (std::size_t c = 0; c < 4; ++c) {
            const auto v = grid.tet(t)[c];
            corners[c] = { grid.vertices(v, 0), grid.vertices(v, 1), grid.vertices(v, 2) };
            far = far || corners[c][0] > around - 1.5;
        }
        for (auto& corner : corners)
            if (far && corner[0] < 1.5)
                corner[0] += around;
        return corners;
    }

    VertexRole role_of(const AortaParameters& p, double layer, double step)
    {
        if (step == 0.0 || step == p.along)
            return VertexRole::fixed;
        return layer == 0.0 ? VertexRole::inner_wall : VertexRole::free;
    }

    ElasticModel sweep_mesh(const Sweep& sweep)
    {
        const AortaParameters& p = sweep.p;
        const mesh::TetMesh grid = kuhn_ring(p);
        ElasticModel body;
        body.mesh = p.nodes_per_tet == 10 ? mesh::with_midpoints(grid) : grid;
        body.roles.resize(body.mesh.vertex_count());
        const auto put = [&](VertexId node, const std::array<double, 3>& at) {
            const double radius
                = p.inner_radius_mm + (p.outer_radius_mm - p.inner_radius_mm) * at[1] / static_cast<double>(p.through);
            const double along = sweep.length * at[2] / p.along, angle = 2.0 * kPi * at[0] / p.around;
            body.mesh.vertices.row(node) = sweep.place(along, angle, radius).transpose();
            const bool held = at[1] == p.through && sweep.branches(along, angle);
            body.roles[static_cast<std::size_t>(node)] = held ? VertexRole::fixed : role_of(p, at[1], at[2]);
        };
        for (TetId t = 0; t < static_cast<TetId>(grid.tet_count()); ++t) {
            const auto corners = unrolled(grid, t, p.around);
            const auto nodes = body.mesh.tet(t);
            std::array<double, 3> middle {};
            for (std::size_t c = 0; c < 4; ++c) {
                put(nodes[c], corners[c]);
                for (std::size_t axis = 0; axis < 3; ++axis)
                    middle[axis] += 0.25 * corners[c][axis];
            }
            for (std::size_t e = 0; e < mesh::kTetEdges.size() && p.nodes_per_tet == 10; ++e) {
                const auto &a = corners[static_cast<std::size_t>(mesh::kTetEdges[e][0])],
                           &b = corners[static_cast<std::size_t>(mesh::kTetEdges[e][1])];
                put(nodes[4 + e], { 0.5 * (a[0] + b[0]), 0.5 * (a[1] + b[1]), 0.5 * (a[2] + b[2]) });
            }
            const bool stiff = sweep.sclerotic(sweep.length * middle[2] / p.along, 2.0 * kPi * middle[0] / p.around);
            body.mesh.labels[static_cast<std::size_t>(t)] = stiff ? kSclerotic : kNormal;
            body.youngs_modulus.push_back(stiff ? p.sclerotic_MPa : p.normal_MPa);
            body.poissons_ratio.push_back(p.poissons_ratio);
        }
        return body;
    }

    void add_sites(PalpationScene& scene, const Sweep& sweep, const std::string& name, double s)
    {
        const double radius = sweep.p.outer_radius_mm;
        for (const bool opposite : { false, true }) {
            const double angle = sweep.site_angle + (opposite ? kPi : 0.0);
            const Vec3 outward = (sweep.place(s, angle, 1.0) - sweep.place(s, angle, 0.0)).normalized();
            scene.sites.push_back({ opposite ? name + "-opposite" : name, sweep.place(s, angle, radius), outward });
        }
    }

} // namespace

PalpationScene make_aorta_phantom(const AortaParameters& parameters)
{
    check(parameters);
    const Sweep sweep(parameters);
    PalpationScene scene;
    scene.body = sweep_mesh(sweep);
    if (parameters.shape == AortaParameters::Shape::arch) {
        scene.name = "aortic arch";
        add_sites(scene, sweep, "normal", kAscending + 0.25 * kArch);
        add_sites(scene, sweep, "sclerotic", kAscending + 0.75 * kArch);
    } else {
        scene.name = "vessel";
        add_sites(scene, sweep, "centre", 0.5 * sweep.length);
    }
    check_elastic_model(scene.body);
    return scene;
}

} // namespace retractor::datasets
