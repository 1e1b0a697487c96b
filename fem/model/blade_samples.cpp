#include "fem/model/blade_samples.h"

#include "mesh/base/error.h"
#include "mesh/base/triangle.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <cmath>
#include <set>
#include <utility>

namespace retractor::fem {

namespace {

    constexpr double kSpacingMm = 2.0; ///< longest side of the part of a face that a sample stands for
    constexpr double kLooksAtBlade = 0.3; ///< least cosine between a face's normal and the direction to the blade
    /// Tissue may slide this far to get under the blade; samples beyond never touch.
    constexpr double kMarginMm = 8.0;
    /// A lip farther from the plane of the blade belongs to another part of the wound.
    constexpr double kLipReachMm = 15.0;
    /// A blade that spares bone may pass this deep through the edge of a rib.
    constexpr double kGrazeMm = 2.0;
    /// Pressure of the penalty per depth, in P-wave moduli of the tissue per edge length (ContactOptions::stiffness).
    constexpr double kPenalty = 20.0;

    class Sampler {
    public:
        Sampler(const mesh::TetMesh& mesh, std::span<const Lame> lame, const BladePlace& place)
            : mesh_(mesh)
            , lame_(lame)
            , nodes_(blade_nodes(place))
            , half_width_(0.5 * place.width_mm)
            , half_height_(0.5 * place.height_mm)
            , normal_(unit_normal(nodes_))
        {
        }

        void add(const mesh::TetFace& face, bool bone, std::vector<BladeSample>& samples) const
        {
            const std::array<VertexId, 3> corners = mesh::face_vertices(mesh_, face);
            const std::array<Vec3, 3> p = triangle_corners(mesh_.vertices, corners);
            if (!looks_at_blade(face))
                return;
            const double longest = std::max({ (p[1] - p[0]).norm(), (p[2] - p[1]).norm(), (p[0] - p[2]).norm() });
            const int parts = std::max(1, static_cast<int>(std::ceil(longest / kSpacingMm)));
            const double area = triangle_area(p) / (parts * parts);
            const Lame& lame = lame_[static_cast<std::size_t>(face.tet)];
            const double edge = std::sqrt(2.0 * triangle_area(p));
            const double stiffness = std::min(kPenalty * (lame.lambda + 2.0 * lame.mu) / edge, kStiffestN_mm3);
            const std::array<std::size_t, 3> local = local_corners(face.tet, corners);
            for (int i = 0; i < parts; ++i)
                for (int j = 0; i + j < parts; ++j)
                    for (const bool upright : { true, false }) {
                        if (!upright && i + j + 1 >= parts)
                            continue;
                        const double third = upright ? 1.0 / 3.0 : 2.0 / 3.0;
                        const double b = (i + third) / parts, c = (j + third) / parts, a = 1.0 - b - c;
                        const Vec3 x = a * p[0] + b * p[1] + c * p[2];
                        const double gap = (x - nodes_[0]).dot(normal_);
                        if (!in_reach(x, gap, bone))
                            continue;
                        BladeSample sample { .tet = face.tet,
                            .area = area,
                            .stiffness = stiffness,
                            .bears_at_mm = bone && gap > 0.0 ? kSqueezedTo * gap : std::min(gap, 0.0),
                            .bone = bone };
                        sample.barycentric[local[0]] = a;
                        sample.barycentric[local[1]] = b;
                        sample.barycentric[local[2]] = c;
                        samples.push_back(sample);
                    }
        }

        /// Marks the vertices near the blade that elements near the blade connect with its lip. Vertices of the other
        /// lip of a cut are not marked.
        std::vector<char> on_side_of(std::span<const mesh::TetFace> lip) const
        {
            std::vector<std::vector<TetId>> elements_at(mesh_.vertex_count());
            for (TetId t = 0; t < static_cast<TetId>(mesh_.tet_count()); ++t)
                for (const VertexId v : mesh_.tet(t))
                    if (is_near(point_at(mesh_.vertices, v)))
                        elements_at[static_cast<std::size_t>(v)].push_back(t);
            std::vector<char> reached(mesh_.vertex_count(), 0);
            std::vector<VertexId> front;
            const auto reach = [&](VertexId v) {
                if (reached[static_cast<std::size_t>(v)] == 0 && !elements_at[static_cast<std::size_t>(v)].empty()) {
                    reached[static_cast<std::size_t>(v)] = 1;
                    front.push_back(v);
                }
            };
            for (const mesh::TetFace& face : lip)
                if (looks_at_blade(face))
                    for (const VertexId v : mesh::face_vertices(mesh_, face))
                        reach(v);
            while (!front.empty()) {
                const VertexId from = front.back();
                front.pop_back();
                for (const TetId t : elements_at[static_cast<std::size_t>(from)])
                    for (const VertexId v : mesh_.tet(t))
                        reach(v);
            }
            return reached;
        }

    private:
        bool looks_at_blade(const mesh::TetFace& face) const
        {
            const auto corners = triangle_corners(mesh_.vertices, mesh::face_vertices(mesh_, face));
            return unit_normal(corners).dot(normal_) < -kLooksAtBlade;
        }

        bool is_near(const Vec3& x) const
        {
            const Vec3 w = x - nodes_[0];
            return std::abs(w.dot((nodes_[1] - nodes_[0]).normalized())) <= half_width_ + kMarginMm
                && std::abs(w.dot((nodes_[2] - nodes_[0]).normalized())) <= half_height_ + kMarginMm
                && std::abs(w.dot(normal_)) <= kLipReachMm;
        }

        bool in_reach(const Vec3& x, double gap, bool bone) const
        {
            return is_near(x) && (!bone || (gap >= -kGrazeMm && gap <= kBoneReachMm));
        }

        std::array<std::size_t, 3> local_corners(TetId tet, const std::array<VertexId, 3>& corners) const
        {
            std::array<std::size_t, 3> local {};
            const auto nodes = mesh_.tet(tet);
            for (std::size_t i = 0; i < corners.size(); ++i)
                local[i] = static_cast<std::size_t>(std::find(nodes.begin(), nodes.end(), corners[i]) - nodes.begin());
            return local;
        }

        const mesh::TetMesh& mesh_;
        std::span<const Lame> lame_;
        std::array<Vec3, 3> nodes_;
        double half_width_, half_height_;
        Vec3 normal_;
    };

} // namespace

std::array<Vec3, 3> blade_nodes(const BladePlace& place)
{
    const std::string where = "blade '" + place.name + "'";
    constexpr double kParallel = 1e-6; // sine of the angle between the axes
    if (!(place.width_mm > 0.0 && std::isfinite(place.width_mm) && place.height_mm > 0.0
            && std::isfinite(place.height_mm)))
        throw InputError("a blade needs a positive width and height", where);
    if (!place.middle.allFinite() || !place.outward.allFinite())
        throw InputError("a number of the blade's place is not finite", where);
    const Vec3 along = place.along.normalized(), across = along.cross(place.deep.normalized());
    if (!(across.norm() > kParallel))
        throw InputError("the blade's axes are zero or parallel", where);
    const Vec3 deep = across.normalized().cross(along);
    const double turn = across.dot(place.outward) < 0.0 ? -1.0 : 1.0;
    return { place.middle, place.middle + 0.5 * turn * place.width_mm * along,
        place.middle + 0.5 * place.height_mm * deep };
}

BladeSurface make_blade_surface(const mesh::TetMesh& mesh, std::span<const Lame> lame,
    std::span<const mesh::TetFace> lip, std::span<const mesh::TetFace> bone, const BladePlace& place,
    const std::array<VertexId, 3>& nodes)
{
    if (lame.size() != mesh.tet_count())
        throw InputError("a blade needs the parameters of each element", "materials");
    const Sampler sampler(mesh, lame, place);
    BladeSurface blade { .name = place.name,
        .nodes = nodes,
        .half_width_mm = 0.5 * place.width_mm,
        .half_height_mm = 0.5 * place.height_mm,
        .friction = place.friction,
        .samples = {} };
    std::set<std::pair<TetId, int>> of_lip;
    for (const mesh::TetFace& face : lip) {
        of_lip.emplace(face.tet, face.corner);
        sampler.add(face, false, blade.samples);
    }
    if (blade.samples.empty())
        throw InputError("no face of the lip looks at the blade", "blade '" + place.name + "'");
    if (bone.empty())
        return blade;
    const std::vector<char> on_side = sampler.on_side_of(lip);
    for (const mesh::TetFace& face : bone) {
        const auto corners = mesh::face_vertices(mesh, face);
        if (!of_lip.contains({ face.tet, face.corner }) && std::any_of(corners.begin(), corners.end(), [&](VertexId v) {
                return on_side[static_cast<std::size_t>(v)] != 0;
            }))
            sampler.add(face, true, blade.samples);
    }
    return blade;
}

std::vector<mesh::TetFace> surface_of_labels(const mesh::TetMesh& mesh, std::span<const Label> labels)
{
    std::vector<TetId> kept;
    const mesh::TetMesh part = mesh::part_with_labels(mesh, labels, &kept);
    std::vector<mesh::TetFace> surface;
    for (const mesh::TetFace& face : mesh::boundary_faces(part))
        surface.push_back({ kept[static_cast<std::size_t>(face.tet)], face.corner });
    return surface;
}

} // namespace retractor::fem
