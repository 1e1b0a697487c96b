#include "planner/session/lip_overlap.h"

#include "mesh/base/assert.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cstddef>
#include <map>

namespace retractor::planner {

std::vector<LipPair> lip_pairs(const mesh::CutSession& session, std::span<const LipTriangle> lips)
{
    std::map<VertexId, Vec3> normal_of; // out of the tissue, weighted by area
    for (const LipTriangle& lip : lips) {
        const auto& [a, b, c] = lip.vertices;
        const Vec3 normal
            = (session.position(b) - session.position(a)).cross(session.position(c) - session.position(a));
        for (const VertexId v : lip.vertices)
            normal_of.emplace(v, Vec3::Zero()).first->second += normal;
    }
    // The halves of a vertex have exactly the same rest position.
    std::map<std::array<double, 3>, std::vector<VertexId>> at;
    for (const auto& [v, normal] : normal_of) {
        const Vec3 p = session.position(v);
        at[{ p.x(), p.y(), p.z() }].push_back(v);
    }
    constexpr double kFacing = -0.5; // otherwise the halves are on two lips that meet at an angle
    std::vector<LipPair> pairs;
    for (const auto& [place, halves] : at)
        for (std::size_t i = 0; i < halves.size(); ++i)
            for (std::size_t j = i + 1; j < halves.size(); ++j) {
                const Vec3 a = normal_of[halves[i]].normalized(), b = normal_of[halves[j]].normalized();
                if (a.dot(b) < kFacing)
                    pairs.push_back({ halves[i], halves[j], (a - b).normalized() });
            }
    return pairs;
}

double lip_overlap_mm(std::span<const LipPair> pairs, const Eigen::VectorXd& displacement)
{
    RETRACTOR_ASSERT(displacement.size() % 3 == 0);
    double deepest = 0.0;
    for (const LipPair& pair : pairs)
        if (3 * static_cast<Eigen::Index>(std::max(pair.a, pair.b)) + 3 <= displacement.size())
            deepest = std::max(
                deepest, (displacement.segment<3>(3 * pair.a) - displacement.segment<3>(3 * pair.b)).dot(pair.normal));
    return deepest;
}

} // namespace retractor::planner
