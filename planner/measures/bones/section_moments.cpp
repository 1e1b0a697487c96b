#include "planner/measures/bones/section_moments.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"
#include "planner/measures/bones/bone_centreline.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace retractor::planner {

namespace {

    constexpr double kNmPerNmm = 1e-3;

    /// Where an edge crosses the section, at rest and in the positions about which the forces balance.
    struct Crossing {
        Vec3 rest, balanced;
    };

    /// Sums over the triangles of a section.
    struct SectionShape {
        double area_mm2 = 0.0;
        Vec3 rest = Vec3::Zero(), balanced = Vec3::Zero(); ///< centroids times area

        void add(const Crossing& a, const Crossing& b, const Crossing& c)
        {
            const double area = 0.5 * (b.rest - a.rest).cross(c.rest - a.rest).norm();
            area_mm2 += area;
            rest += area / 3.0 * (a.rest + b.rest + c.rest);
            balanced += area / 3.0 * (a.balanced + b.balanced + c.balanced);
        }
    };

    /// Adds the part of the section in an element: where the distance along the bone, linear between corners, is at_mm.
    void add_element(
        SectionShape& shape, const BoneForces& bone, const std::vector<double>& along, TetId t, double at_mm)
    {
        std::array<std::size_t, 4> below {}, above {};
        std::size_t low = 0, high = 0;
        for (std::size_t a = 0; a < 4; ++a) {
            const auto v = static_cast<std::size_t>(bone.part.tet(t)[a]);
            along[v] > at_mm ? above[high++] = v : below[low++] = v;
        }
        if (low == 0 || high == 0)
            return;
        const auto crossing = [&](std::size_t from, std::size_t to) {
            const double share = (at_mm - along[from]) / (along[to] - along[from]);
            const auto between = [&](const Points& points) -> Vec3 {
                const Vec3 a = point_at(points, static_cast<VertexId>(from)),
                           b = point_at(points, static_cast<VertexId>(to));
                return a + share * (b - a);
            };
            return Crossing { between(bone.part.vertices), between(bone.positions) };
        };
        if (low == 2) {
            const std::array corners { crossing(below[0], above[0]), crossing(below[0], above[1]),
                crossing(below[1], above[1]), crossing(below[1], above[0]) };
            shape.add(corners[0], corners[1], corners[2]);
            shape.add(corners[0], corners[2], corners[3]);
        } else if (low == 1) {
            shape.add(crossing(below[0], above[0]), crossing(below[0], above[1]), crossing(below[0], above[2]));
        } else {
            shape.add(crossing(below[0], above[0]), crossing(below[1], above[0]), crossing(below[2], above[0]));
        }
    }

    SectionShape section_shape(const BoneForces& bone, const std::vector<double>& along, double at_mm)
    {
        SectionShape shape;
        for (TetId t = 0; t < static_cast<TetId>(bone.part.tet_count()); ++t)
            add_element(shape, bone, along, t, at_mm);
        return shape;
    }

    /// Moment of the forces beyond a section about its centroid, N mm.
    Vec3 moment_beyond(const BoneForces& bone, const std::vector<double>& along, double at_mm, const Vec3& centroid)
    {
        Vec3 moment = Vec3::Zero();
        for (std::size_t v = 0; v < along.size(); ++v)
            if (along[v] > at_mm) {
                const auto i = static_cast<VertexId>(v);
                moment += (point_at(bone.positions, i) - centroid).cross(point_at(bone.forces, i));
            }
        return moment;
    }

} // namespace

BoneBar section_moments(const BoneForces& bone, double spacing_mm)
{
    if (!(spacing_mm > 0.0))
        throw InputError("the distance between the sections of a bone must be positive");
    RETRACTOR_ASSERT(bone.positions.rows() == bone.part.vertices.rows() && bone.forces.rows() == bone.positions.rows());
    const BoneCentreline line = bone_centreline(bone.part);
    BoneBar bar { .length_mm = line.length_mm, .sections = {} };
    std::vector<Vec3> centroids; // in the positions about which the forces balance
    for (double at = spacing_mm; at < line.length_mm - 0.5 * spacing_mm; at += spacing_mm) {
        const SectionShape shape = section_shape(bone, line.along_mm, at);
        if (!(shape.area_mm2 > 0.0))
            continue;
        bar.sections.push_back({ .at_mm = at, .centre = shape.rest / shape.area_mm2, .area_mm2 = shape.area_mm2 });
        centroids.emplace_back(shape.balanced / shape.area_mm2);
    }
    if (centroids.size() < 2)
        bar.sections.clear();
    for (std::size_t i = 0; i < bar.sections.size(); ++i) {
        BoneSection& section = bar.sections[i];
        const std::size_t before = i == 0 ? 0 : i - 1, after = std::min(i + 1, centroids.size() - 1);
        const Vec3 axis = (centroids[after] - centroids[before]).normalized();
        const Vec3 moment = moment_beyond(bone, line.along_mm, section.at_mm, centroids[i]);
        const double torsion = moment.dot(axis);
        section.torsion_Nm = kNmPerNmm * std::abs(torsion);
        section.bending_Nm = kNmPerNmm * (moment - torsion * axis).norm();
    }
    return bar;
}

BoneBar reversed(BoneBar bar)
{
    std::ranges::reverse(bar.sections);
    for (BoneSection& section : bar.sections)
        section.at_mm = bar.length_mm - section.at_mm;
    return bar;
}

} // namespace retractor::planner
