#include "planner/wall/bones_through_skin.h"

#include "mesh/base/assert.h"
#include "mesh/base/triangle.h"
#include "mesh/image/skeleton.h"
#include "mesh/surface/proximity.h"
#include "mesh/surface/wound_surface.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <map>
#include <optional>
#include <utility>

namespace retractor::planner {

namespace {

    /// Searches for the skin, the nearest first: a wide search meets many triangles. Bone deeper than the last is
    /// inside.
    constexpr std::array kSearchesMm { 4.0, 8.0, 15.0, 30.0, 60.0 };
    /// Triangles within this distance of the nearest one meet at the nearest point.
    constexpr double kSamePlaceMm = 1e-6;

    /// A surface, with the edges at which it ends.
    class Skin {
    public:
        void add(const TriMesh& surface, std::span<const std::size_t> triangles)
        {
            const auto first = static_cast<VertexId>(points_.size());
            for (Eigen::Index v = 0; v < surface.vertices.rows(); ++v)
                points_.push_back(surface.vertices.row(v).transpose());
            for (const std::size_t t : triangles) {
                std::array<VertexId, 3> corners = surface.triangles[t];
                for (VertexId& corner : corners)
                    corner += first;
                triangles_.push_back(corners);
            }
        }

        bool empty() const { return triangles_.empty(); }

        void prepare()
        {
            vertices_.resize(static_cast<Eigen::Index>(points_.size()), 3);
            for (std::size_t v = 0; v < points_.size(); ++v)
                vertices_.row(static_cast<Eigen::Index>(v)) = points_[v].transpose();
            for (const auto& corners : triangles_)
                for (std::size_t c = 0; c < 3; ++c)
                    ++uses_[edge(corners, c)];
            for (const double reach : kSearchesMm)
                near_.emplace_back(vertices_, triangles_, reach);
        }

        /// Distance of a point outside the skin (negative inside); nothing where the skin is far, or ends.
        std::optional<double> outside(const Vec3& point) const
        {
            for (std::size_t n = 0; n < near_.size(); ++n) {
                const auto found = near_[n].within(point, kSearchesMm[n]);
                if (found.empty())
                    continue;
                const double distance = found.front().point.distance;
                if (distance == 0.0)
                    return 0.0;
                Vec3 normal = Vec3::Zero(), nearest = Vec3::Zero();
                for (const auto& nearby : found) {
                    if (nearby.point.distance > distance + kSamePlaceMm)
                        break;
                    const auto& corners = triangles_[static_cast<std::size_t>(nearby.triangle)];
                    if (ends_at(corners, nearby.point.barycentric))
                        return std::nullopt;
                    normal += unit_normal(vertices_, corners);
                    if (nearest.isZero(0.0))
                        nearest = at(corners, nearby.point.barycentric);
                }
                return (point - nearest).dot(normal) > 0.0 ? distance : -distance;
            }
            return std::nullopt;
        }

    private:
        using Edge = std::pair<VertexId, VertexId>;

        static Edge edge(const std::array<VertexId, 3>& corners, std::size_t opposite)
        {
            return std::minmax(corners[(opposite + 1) % 3], corners[(opposite + 2) % 3]);
        }

        Vec3 at(const std::array<VertexId, 3>& corners, const Vec3& barycentric) const
        {
            const auto [a, b, c] = triangle_corners(vertices_, corners);
            return barycentric[0] * a + barycentric[1] * b + barycentric[2] * c;
        }

        /// Whether this place of a triangle lies on an edge without a second triangle.
        bool ends_at(const std::array<VertexId, 3>& corners, const Vec3& barycentric) const
        {
            for (std::size_t c = 0; c < 3; ++c)
                if (barycentric[static_cast<Eigen::Index>(c)] == 0.0 && uses_.at(edge(corners, c)) == 1)
                    return true;
            return false;
        }

        std::vector<Vec3> points_;
        std::vector<std::array<VertexId, 3>> triangles_;
        Points vertices_;
        std::map<Edge, int> uses_;
        std::vector<mesh::TriangleProximity> near_;
    };

    std::vector<std::size_t> labelled(const TriMesh& surface, const mesh::LabelFlags& wanted)
    {
        std::vector<std::size_t> triangles;
        for (std::size_t t = 0; t < surface.labels.size(); ++t)
            if (wanted[surface.labels[t]] != 0)
                triangles.push_back(t);
        return triangles;
    }

    /// The outer skin of a mesh, without the faces where the skin was cut off.
    void add_skin_of(Skin& skin, const mesh::TetMesh& wall, const Points& displacement,
        std::span<const std::uint8_t> is_rim, const mesh::LabelFlags& is_skin)
    {
        const mesh::TetSurface meshed = mesh::boundary_surface(wall, displacement);
        std::vector<std::size_t> outer = labelled(meshed.surface, is_skin);
        std::erase_if(outer, [&](std::size_t t) {
            return std::ranges::all_of(meshed.surface.triangles[t], [&](VertexId corner) {
                return is_rim[static_cast<std::size_t>(meshed.vertex_of[static_cast<std::size_t>(corner)])] != 0;
            });
        });
        skin.add(meshed.surface, outer);
    }

    /// Per vertex the label of the bare bone to which it belongs; 0: other tissue lies round it, or it is no rim.
    std::vector<Label> bare_bones(
        const mesh::TetMesh& wall, std::span<const std::uint8_t> is_rim, const mesh::LabelTable& table)
    {
        const mesh::LabelFlags bone = mesh::flagged_labels(table, mesh::is_skeleton);
        std::vector<Label> of_vertex(wall.vertex_count(), 0);
        std::vector<std::uint8_t> covered(wall.vertex_count(), 0);
        for (TetId t = 0; t < static_cast<TetId>(wall.tet_count()); ++t) {
            const Label label = wall.labels[static_cast<std::size_t>(t)];
            for (const VertexId v : wall.tet(t)) {
                if (bone[label] == 0)
                    covered[static_cast<std::size_t>(v)] = 1;
                else
                    of_vertex[static_cast<std::size_t>(v)] = label;
            }
        }
        for (std::size_t v = 0; v < of_vertex.size(); ++v)
            if (covered[v] != 0 || is_rim[v] == 0)
                of_vertex[v] = 0;
        return of_vertex;
    }

} // namespace

std::vector<PiercingBone> bones_through_skin(const mesh::TetMesh& wall, const Points& displacement,
    std::span<const std::uint8_t> is_rim, const TriMesh& beyond, const mesh::LabelTable& table)
{
    RETRACTOR_ASSERT(is_rim.size() == wall.vertex_count() && displacement.rows() == wall.vertices.rows());
    RETRACTOR_ASSERT(beyond.triangles.empty() || beyond.labels.size() == beyond.triangles.size());
    const std::vector<Label> bare = bare_bones(wall, is_rim, table);
    if (std::ranges::all_of(bare, [](Label label) { return label == 0; }))
        return {};
    const mesh::LabelFlags is_skin
        = mesh::flagged_labels(table, [](const mesh::LabelInfo& info) { return info.material == "skin"; });
    Skin skin, at_rest;
    add_skin_of(skin, wall, displacement, is_rim, is_skin);
    skin.add(beyond, labelled(beyond, is_skin));
    if (skin.empty())
        return {};
    skin.prepare();
    if (beyond.triangles.empty()) {
        add_skin_of(at_rest, wall, Points::Zero(displacement.rows(), 3), is_rim, is_skin);
        at_rest.prepare();
    }
    std::map<Label, PiercingBone> worst;
    for (std::size_t v = 0; v < bare.size(); ++v) {
        if (bare[v] == 0)
            continue;
        const auto row = static_cast<Eigen::Index>(v);
        const Vec3 at = wall.vertices.row(row).transpose();
        std::optional<double> out = skin.outside(at + displacement.row(row).transpose());
        if (!out || *out < kLeastPiercingMm)
            continue;
        if (!at_rest.empty())
            *out -= std::max(0.0, at_rest.outside(at).value_or(0.0));
        if (*out < kLeastPiercingMm)
            continue;
        PiercingBone& bone = worst[bare[v]];
        if (*out > bone.out_mm)
            bone = { mesh::find_label(table, bare[v])->name, *out, at };
    }
    std::vector<PiercingBone> bones;
    for (const auto& [label, bone] : worst)
        bones.push_back(bone);
    std::ranges::stable_sort(bones, std::ranges::greater {}, &PiercingBone::out_mm);
    return bones;
}

} // namespace retractor::planner
