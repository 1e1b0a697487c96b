#include "haptics/hand/hand_file.h"

#include "haptics/hand/obj_surface.h"
#include "mesh/base/error.h"

#include <map>
#include <string>
#include <utility>
#include <vector>

namespace retractor::haptics {

namespace {

    // mm, diagonal of the box: a child's hand; an adult's hand with the forearm
    constexpr double kShortest = 80.0, kLongest = 600.0;
    constexpr double kThinnest = 1.0, kThickest = 30.0; // radius of a fingertip, mm

    [[noreturn]] void refuse(const std::string& what, const std::filesystem::path& path)
    {
        throw InputError(what, path.string());
    }

    std::string millimetres(double length)
    {
        std::string text = std::to_string(length);
        text.resize(text.find('.') + 3);
        return text + " mm";
    }

} // namespace

HandModel read_hand(const std::filesystem::path& path, bool left)
{
    HandModel hand;
    std::map<std::string, std::vector<VertexId>> groups;
    hand.surface = read_obj_surface(path, 1.0, &groups);
    Points& at = hand.surface.vertices;
    const double size = (at.colwise().maxCoeff() - at.colwise().minCoeff()).norm();
    if (!(size >= kShortest && size <= kLongest))
        refuse(
            "the hand measures " + millimetres(size) + " from corner to corner: its unit must be the millimetre", path);
    for (std::size_t f = 0; f < hand.tips.size(); ++f) {
        const std::string name = "fingertip-" + std::to_string(f + 1);
        const auto found = groups.find(name);
        if (found == groups.end())
            refuse("has no group " + name
                    + ": the faces of each fingertip belong in one, fingertip-1 (thumb) to fingertip-5 (little finger)",
                path);
        Vec3 middle = Vec3::Zero();
        for (const VertexId v : found->second)
            middle += at.row(v).transpose() / static_cast<double>(found->second.size());
        double radius = 0.0;
        for (const VertexId v : found->second)
            radius += (at.row(v).transpose() - middle).norm() / static_cast<double>(found->second.size());
        if (!(radius >= kThinnest && radius <= kThickest))
            refuse(name + " has a radius of " + millimetres(radius) + ", no fingertip's", path);
        hand.tips[f] = middle;
        hand.tip_radius[f] = radius;
    }
    if (left) {
        at.col(0) = -at.col(0);
        for (Vec3& tip : hand.tips)
            tip.x() = -tip.x();
        for (auto& triangle : hand.surface.triangles)
            std::swap(triangle[1], triangle[2]);
    }
    return hand;
}

} // namespace retractor::haptics
