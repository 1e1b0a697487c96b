#include "mesh/generation/mesh_polish.h"

#include "mesh/base/assert.h"
#include "mesh/base/triangle.h"
#include "mesh/tetrahedra/tet_mesh.h"

#include <algorithm>
#include <array>
#include <optional>
#include <span>
#include <vector>

namespace retractor::mesh {

namespace {

    constexpr int kPasses = 4; ///< passes over the flat elements
    constexpr int kClimbSteps = 12; ///< halvings or moves per vertex
    constexpr double kFirstStep = 0.15; ///< share of the vertex's mean edge
    /// Below this angle (degrees), vertices where three labels meet may leave their curve.
    constexpr double kJunctionAngle = 7.0;
    constexpr double kJunctionReach = 0.15; ///< largest such move, as a share of the mean edge
    constexpr int kFitPasses = 2;
    // Cosines of angles between an interface face and the normal at a corner. The fit turns no face farther than this
    // limit, except at a crease of the interface.
    constexpr double kRoughest = 0.9;
    constexpr double kCrease = 0.8;
    constexpr double kTolerance = 0.01; ///< mm; tolerance of searches on the label function

    std::size_t u(VertexId v) { return static_cast<std::size_t>(v); }

    /// The elements round each vertex.
    struct Stars {
        std::vector<std::size_t> begin;
        std::vector<std::uint32_t> tets;

        explicit Stars(const LocalMesh& mesh)
            : begin(mesh.vertices.size() + 1, 0)
            , tets(4 * mesh.tets.size())
        {
            RETRACTOR_ASSERT(mesh.labels.size() == mesh.tets.size());
            for (const auto& tet : mesh.tets)
                for (const VertexId v : tet)
                    ++begin[u(v) + 1];
            for (std::size_t v = 0; v < mesh.vertices.size(); ++v)
                begin[v + 1] += begin[v];
            std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
            for (std::size_t t = 0; t < mesh.tets.size(); ++t)
                for (const VertexId v : mesh.tets[t])
                    tets[next[u(v)]++] = static_cast<std::uint32_t>(t);
        }
        std::span<const std::uint32_t> of(VertexId v) const
        {
            return { tets.data() + begin[u(v)], begin[u(v) + 1] - begin[u(v)] };
        }
    };

    /// A face on an interface, oriented outwards from the label `inside`; `outside` may be 0.
    struct InterfaceFace {
        std::array<VertexId, 3> vertices;
        int inside = 0, outside = 0;
    };

    std::vector<InterfaceFace> interface_faces(const LocalMesh& mesh)
    {
        struct Record {
            std::array<VertexId, 3> key;
            InterfaceFace face;
        };
        std::vector<Record> records;
        records.reserve(4 * mesh.tets.size());
        for (std::size_t t = 0; t < mesh.tets.size(); ++t)
            for (int corner = 0; corner < 4; ++corner) {
                const InterfaceFace face { face_corners(mesh.tets[t], corner), mesh.labels[t] };
                std::array<VertexId, 3> key = face.vertices;
                std::sort(key.begin(), key.end());
                records.push_back({ key, face });
            }
        std::sort(records.begin(), records.end(), [](const Record& a, const Record& b) {
            return a.key != b.key ? a.key < b.key : a.face.inside > b.face.inside;
        });
        std::vector<InterfaceFace> faces;
        for (std::size_t i = 0; i < records.size(); ++i) {
            const bool paired = i + 1 < records.size() && records[i + 1].key == records[i].key;
            InterfaceFace face = records[i].face;
            face.outside = paired ? records[i + 1].face.inside : 0;
            if (face.inside != face.outside)
                faces.push_back(face);
            i += paired;
        }
        return faces;
    }

    /// Permitted moves of a vertex: anywhere inside one label, along the interface of two labels, or no move.
    struct Freedom {
        enum Kind : std::uint8_t { inner, on_interface, fixed } kind = inner;
        int inside = 0, outside = 0;
    };

    std::vector<Freedom> freedoms(const LocalMesh& mesh, const std::vector<InterfaceFace>& faces)
    {
        std::vector<Freedom> freedom(mesh.vertices.size());
        for (const InterfaceFace& face : faces)
            for (const VertexId v : face.vertices) {
                Freedom& of = freedom[u(v)];
                if (of.kind == Freedom::inner)
                    of = { Freedom::on_interface, face.inside, face.outside };
                else if (of.inside != face.inside || of.outside != face.outside)
                    of.kind = Freedom::fixed;
            }
        return freedom;
    }

    double smallest_angle(const LocalMesh& mesh, std::size_t t)
    {
        const auto& tet = mesh.tets[t];
        const Vec3 &a = mesh.vertices[u(tet[0])], &b = mesh.vertices[u(tet[1])], &c = mesh.vertices[u(tet[2])],
                   &d = mesh.vertices[u(tet[3])];
        if (tet_volume(a, b, c, d) <= 0.0)
            return -1.0;
        const auto angles = dihedral_angles_deg(a, b, c, d);
        return *std::min_element(angles.begin(), angles.end());
    }

    double smallest_angle(const LocalMesh& mesh, std::span<const std::uint32_t> star)
    {
        double smallest = 180.0;
        for (const std::uint32_t t : star)
            smallest = std::min(smallest, smallest_angle(mesh, t));
        return smallest;
    }

    /// Unit normal of the interface at v, out of label `inside`. The interface's faces round v and the faces opposite v
    /// in the elements of that label form a closed surface, so that their area vectors cancel.
    Vec3 interface_normal(const LocalMesh& mesh, const Stars& stars, VertexId v, int inside)
    {
        Vec3 sum = Vec3::Zero();
        for (const std::uint32_t t : stars.of(v)) {
            if (mesh.labels[t] != inside)
                continue;
            const auto& tet = mesh.tets[t];
            const auto [a, b, c]
                = face_corners(tet, static_cast<int>(std::find(tet.begin(), tet.end(), v) - tet.begin()));
            const Vec3& from = mesh.vertices[u(a)];
            sum -= (mesh.vertices[u(b)] - from).cross(mesh.vertices[u(c)] - from);
        }
        return sum.normalized();
    }

    /// Signed distance (mm) along `normal` (out of `inside`) from p to the interface of the two labels; nothing when
    /// the interface is farther than `reach`.
    std::optional<double> offset_to_interface(
        const LabelField& field, const Vec3& p, const Vec3& normal, int inside, int outside, double reach)
    {
        const int here = field.at(p);
        if (here != inside && here != outside)
            return std::nullopt;
        const double sign = here == inside ? 1.0 : -1.0;
        const double step = 0.125 * field.wall().spacing.minCoeff();
        for (double d = step; d < reach + step; d += step) {
            const int there = field.at(p + sign * d * normal);
            if (there == here)
                continue;
            if (there != (here == inside ? outside : inside))
                return std::nullopt;
            const Vec3 on = field.crossing(p + sign * (d - step) * normal, p + sign * d * normal, kTolerance);
            return (on - p).dot(normal);
        }
        return std::nullopt;
    }

    /// Interface faces round each vertex.
    std::vector<std::vector<std::uint32_t>> faces_round(const LocalMesh& mesh, const std::vector<InterfaceFace>& faces)
    {
        std::vector<std::vector<std::uint32_t>> round(mesh.vertices.size());
        for (std::size_t f = 0; f < faces.size(); ++f)
            for (const VertexId v : faces[f].vertices)
                round[u(v)].push_back(static_cast<std::uint32_t>(f));
        return round;
    }

    /// Cosine of the largest angle between an interface face at v and `normal`.
    double smoothness(const LocalMesh& mesh, const std::vector<InterfaceFace>& faces,
        const std::vector<std::uint32_t>& round, const Vec3& normal)
    {
        double least = 1.0;
        for (const std::uint32_t f : round) {
            const auto& v = faces[f].vertices;
            const Vec3 &a = mesh.vertices[u(v[0])], &b = mesh.vertices[u(v[1])], &c = mesh.vertices[u(v[2])];
            least = std::min(least, unit_normal(a, b, c).dot(normal));
        }
        return least;
    }

    /// The body's surface at a vertex.
    struct SurfaceAt {
        Vec3 normal = Vec3::Zero(); ///< unit, outwards; zero where there is no surface, or where it has no one side
        double smoothness = 1.0; ///< cosine of the largest angle between a face and the normal
    };

    SurfaceAt surface_at(
        const LocalMesh& mesh, const std::vector<InterfaceFace>& faces, std::span<const std::uint32_t> round)
    {
        constexpr double kOneSided = 0.3; // of the faces' area
        Vec3 sum = Vec3::Zero();
        double area = 0.0;
        std::vector<Vec3> normals;
        for (const std::uint32_t f : round) {
            if (faces[f].outside != 0)
                continue;
            const auto& [a, b, c] = faces[f].vertices;
            const Vec3& from = mesh.vertices[u(a)];
            const Vec3 of_face = (mesh.vertices[u(b)] - from).cross(mesh.vertices[u(c)] - from);
            sum += of_face;
            area += of_face.norm();
            normals.push_back(of_face.normalized());
        }
        if (sum.norm() <= kOneSided * area)
            return {};
        SurfaceAt surface { .normal = sum.normalized() };
        for (const Vec3& normal : normals)
            surface.smoothness = std::min(surface.smoothness, normal.dot(surface.normal));
        return surface;
    }

    /// Distance (mm) from p, which lies in the body, along `normal` to where the body ends; nothing where it does not
    /// end within `reach`.
    std::optional<double> depth_below_surface(const LabelField& field, const Vec3& p, const Vec3& normal, double reach)
    {
        if (field.at(p) == 0)
            return std::nullopt;
        const double step = 0.25 * field.wall().spacing.minCoeff();
        for (double d = step; d < reach + step; d += step)
            if (field.at(p + d * normal) == 0)
                return (field.crossing(p + (d - step) * normal, p + d * normal, kTolerance) - p).dot(normal);
        return std::nullopt;
    }

    double mean_edge(const LocalMesh& mesh, VertexId v, std::span<const std::uint32_t> star)
    {
        RETRACTOR_ASSERT(!star.empty());
        double sum = 0.0;
        for (const std::uint32_t t : star)
            for (const VertexId w : mesh.tets[t])
                sum += (mesh.vertices[u(w)] - mesh.vertices[u(v)]).norm();
        return sum / (3.0 * static_cast<double>(star.size()));
    }

    constexpr std::array<std::array<double, 3>, 14> kDirections { { { 1, 0, 0 }, { -1, 0, 0 }, { 0, 1, 0 },
        { 0, -1, 0 }, { 0, 0, 1 }, { 0, 0, -1 }, { .577, .577, .577 }, { -.577, .577, .577 }, { .577, -.577, .577 },
        { .577, .577, -.577 }, { -.577, -.577, .577 }, { -.577, .577, -.577 }, { .577, -.577, -.577 },
        { -.577, -.577, -.577 } } };

    /// Pattern search for the position of v that maximises the smallest angle round v, up to `enough`.
    void climb(
        LocalMesh& mesh, const LabelField& field, const Stars& stars, VertexId v, const Freedom& freedom, double enough)
    {
        const auto star = stars.of(v);
        double best = smallest_angle(mesh, star);
        const Vec3 start = mesh.vertices[u(v)];
        const double edge = mean_edge(mesh, v, star);
        double step = kFirstStep * edge;
        const Vec3 normal
            = freedom.kind == Freedom::on_interface ? interface_normal(mesh, stars, v, freedom.inside) : Vec3::Zero();
        for (int i = 0; i < kClimbSteps && best < enough; ++i) {
            const Vec3 from = mesh.vertices[u(v)];
            Vec3 to = from;
            for (const auto& direction : kDirections) {
                Vec3 candidate = from + step * Vec3(direction[0], direction[1], direction[2]);
                if (freedom.kind == Freedom::on_interface) {
                    candidate -= (candidate - from).dot(normal) * normal;
                    const auto offset
                        = offset_to_interface(field, candidate, normal, freedom.inside, freedom.outside, 0.5 * step);
                    if (!offset)
                        continue;
                    candidate += *offset * normal;
                }
                if (freedom.kind == Freedom::fixed && (candidate - start).norm() > kJunctionReach * edge)
                    continue;
                mesh.vertices[u(v)] = candidate;
                if (const double angle = smallest_angle(mesh, star); angle > best) {
                    best = angle;
                    to = candidate;
                }
            }
            mesh.vertices[u(v)] = to;
            if (to == from)
                step *= 0.5;
        }
    }

} // namespace

void open_flat_tets(LocalMesh& mesh, const LabelField& field, double target_deg, const Job& job)
{
    const Stars stars(mesh);
    const std::vector<Freedom> freedom = freedoms(mesh, interface_faces(mesh));
    for (int pass = 0; pass < kPasses && !job.cancelled(); ++pass)
        for (std::size_t t = 0; t < mesh.tets.size(); ++t)
            for (std::size_t i = 0; i < 4 && smallest_angle(mesh, t) < target_deg; ++i)
                if (const VertexId v = mesh.tets[t][i]; freedom[u(v)].kind != Freedom::fixed)
                    climb(mesh, field, stars, v, freedom[u(v)], target_deg);
    for (std::size_t t = 0; t < mesh.tets.size(); ++t)
        for (std::size_t i = 0; i < 4 && smallest_angle(mesh, t) < kJunctionAngle; ++i)
            if (const VertexId v = mesh.tets[t][i]; freedom[u(v)].kind == Freedom::fixed)
                climb(mesh, field, stars, v, freedom[u(v)], kJunctionAngle);
}

void raise_pits(LocalMesh& mesh, const LabelField& field, double smallest_deg, const Job& job)
{
    constexpr double kDeep = 0.5; // voxels
    constexpr int kPitPasses = 2; // the bottom of a wide pit is several vertices
    constexpr std::array kShares { 1.0, 0.75, 0.5, 0.25 }; // of the way out
    const Stars stars(mesh);
    const std::vector<InterfaceFace> faces = interface_faces(mesh);
    const auto round = faces_round(mesh, faces);
    const double voxel = field.wall().spacing.maxCoeff();
    for (int pass = 0; pass < kPitPasses && !job.cancelled(); ++pass)
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertices.size()); ++v) {
            const auto [normal, smoothness] = surface_at(mesh, faces, round[u(v)]);
            if (normal.isZero())
                continue;
            const double edge = mean_edge(mesh, v, stars.of(v));
            const Vec3 from = mesh.vertices[u(v)];
            const std::optional<double> depth = depth_below_surface(field, from, normal, edge);
            if (!depth || *depth <= kDeep * voxel)
                continue;
            const double enough = std::min(smallest_angle(mesh, stars.of(v)), smallest_deg);
            for (const double share : kShares) {
                mesh.vertices[u(v)] = from + share * *depth * normal;
                if (smallest_angle(mesh, stars.of(v)) >= enough
                    && surface_at(mesh, faces, round[u(v)]).smoothness >= smoothness)
                    break;
                mesh.vertices[u(v)] = from;
            }
        }
}

void fit_interfaces(LocalMesh& mesh, const LabelField& field, double smallest_deg, const Job& job)
{
    const Stars stars(mesh);
    const std::vector<InterfaceFace> faces = interface_faces(mesh);
    const std::vector<Freedom> freedom = freedoms(mesh, faces);
    const auto round = faces_round(mesh, faces);
    const double reach = 1.5 * field.wall().spacing.maxCoeff();
    for (int pass = 0; pass < kFitPasses && !job.cancelled(); ++pass) {
        std::vector<double> weighted(mesh.vertices.size(), 0.0), area_sum(mesh.vertices.size(), 0.0);
        for (const InterfaceFace& face : faces) {
            const Vec3 &a = mesh.vertices[u(face.vertices[0])], &b = mesh.vertices[u(face.vertices[1])],
                       &c = mesh.vertices[u(face.vertices[2])];
            const Vec3 area = (b - a).cross(c - a);
            const Vec3 normal = area.normalized();
            for (const Vec3& p :
                { Vec3((4 * a + b + c) / 6.0), Vec3((a + 4 * b + c) / 6.0), Vec3((a + b + 4 * c) / 6.0) })
                if (const auto offset = offset_to_interface(field, p, normal, face.inside, face.outside, reach))
                    for (const VertexId v : face.vertices) {
                        weighted[u(v)] += area.norm() * *offset;
                        area_sum[u(v)] += area.norm();
                    }
        }
        for (VertexId v = 0; v < static_cast<VertexId>(mesh.vertices.size()); ++v) {
            if (freedom[u(v)].kind != Freedom::on_interface || area_sum[u(v)] == 0.0)
                continue;
            const Vec3 from = mesh.vertices[u(v)];
            const double before = smallest_angle(mesh, stars.of(v));
            const Vec3 normal = interface_normal(mesh, stars, v, freedom[u(v)].inside);
            const double smooth = smoothness(mesh, faces, round[u(v)], normal);
            mesh.vertices[u(v)] += weighted[u(v)] / area_sum[u(v)] * normal;
            const bool crumples
                = smooth > kCrease && smoothness(mesh, faces, round[u(v)], normal) < std::min(smooth, kRoughest);
            if (crumples || smallest_angle(mesh, stars.of(v)) < std::min(before, smallest_deg))
                mesh.vertices[u(v)] = from;
        }
    }
}

} // namespace retractor::mesh
