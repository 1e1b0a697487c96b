#include "haptics/condensed/fingertip_search.h"

#include "mesh/base/assert.h"
#include "mesh/surface/proximity.h"

#include <Eigen/Geometry>

#include <algorithm>
#include <array>
#include <cmath>

namespace retractor::haptics {

namespace {

    constexpr std::size_t kMostSeen = 512; ///< largest number of contact nodes that one search of a finger tests
    constexpr double kNowhere = -1e30; ///< demand of a contact node out of reach

} // namespace

FingertipSearch::FingertipSearch(const TouchSurface& surface, FingertipShape shape)
    : surface_(&surface)
    , shape_(shape)
    , seen_(surface.contact_nodes().size(), 0)
    , queue_(kMostSeen)
{
}

void FingertipSearch::go_on_from(const FingertipSearch& before) noexcept
{
    outside_ = before.outside_;
    last_ = before.last_;
    touched_ = before.touched_ && surface_ == before.surface_;
    vertex_ = before.vertex_;
}

Vec3 FingertipSearch::position(std::int32_t vertex, const ContactNodeCompliance& body, double pressure) const noexcept
{
    return surface_->rest().row(vertex).transpose() + pressure * body.pulse_of_vertex(vertex);
}

std::int32_t FingertipSearch::walk(
    std::int32_t from, const Vec3& to, const ContactNodeCompliance& body, double pressure) const noexcept
{
    double best = (position(from, body, pressure) - to).squaredNorm();
    constexpr int kSteps = 64;
    for (int step = 0; step < kSteps; ++step) {
        const std::int32_t start = from;
        for (const std::int32_t v : surface_->neighbours().of(static_cast<std::size_t>(start)))
            if (const double d = (position(v, body, pressure) - to).squaredNorm(); d < best) {
                best = d;
                from = v;
            }
        if (from == start)
            break;
    }
    return from;
}

TouchedPlace FingertipSearch::find(const Fingertip& finger, const ContactNodeCompliance& body, double pressure) noexcept
{
    TouchedPlace place;
    const double jump = 4.0 * finger.radius;
    if ((finger.position - last_).squaredNorm() > jump * jump)
        touched_ = outside_ = false;
    last_ = finger.position;
    const std::int32_t start = touched_ ? vertex_ : surface_->near(finger.position);
    touched_ = false;
    if (start < 0) {
        outside_ = true;
        return place;
    }
    vertex_ = walk(start, finger.position, body, pressure);
    double best = -1.0;
    Vec3 point = Vec3::Zero(), at_rest = Vec3::Zero(), normal = Vec3::Zero();
    for (const std::int32_t t : surface_->triangles_round().of(static_cast<std::size_t>(vertex_))) {
        const auto& corner = surface_->triangles()[static_cast<std::size_t>(t)];
        const std::array<Vec3, 3> at { position(corner[0], body, pressure), position(corner[1], body, pressure),
            position(corner[2], body, pressure) };
        const mesh::ClosestPoint closest = mesh::closest_on_triangle(finger.position, at[0], at[1], at[2]);
        if (best >= 0.0 && closest.distance >= best)
            continue;
        best = closest.distance;
        const Vec3& weight = closest.barycentric;
        point = weight[0] * at[0] + weight[1] * at[1] + weight[2] * at[2];
        normal.setZero();
        at_rest.setZero();
        for (std::size_t i = 0; i < 3; ++i) {
            const double share = weight[static_cast<Eigen::Index>(i)];
            normal += share * surface_->normals().row(corner[i]).transpose();
            at_rest += share * surface_->rest().row(corner[i]).transpose();
        }
    }
    normal.normalize();
    const double height = (finger.position - point).dot(normal);
    const double aside = (finger.position - point - height * normal).norm();
    if (aside > 0.5 * finger.radius) { // the finger is past a rim
        outside_ = height >= 0.0;
        return place;
    }
    const bool from_outside = outside_;
    outside_ = height >= 0.0 || outside_;
    if (height >= finger.radius)
        return place;
    if (height < 0.0 && !from_outside)
        return place;
    place = { true, normal, finger.radius - height, finger.radius - (finger.position - at_rest).dot(normal), vertex_ };
    touched_ = true;
    return place;
}

double FingertipSearch::demand(const Fingertip& finger, const TouchedPlace& place, std::int32_t contact_node,
    const ContactNodeCompliance& body, double pressure) const noexcept
{
    const ContactNode& s = surface_->contact_nodes()[static_cast<std::size_t>(contact_node)];
    constexpr double kFacing = 0.2; // excludes the far side of a thin vessel
    if (s.normal.dot(place.normal) < kFacing)
        return kNowhere;
    const Vec3 pulse = pressure * body.pulse_of_contact_node(contact_node);
    const Vec3 from = s.point + pulse - finger.position;
    const double above = from.dot(place.normal), off2 = from.squaredNorm() - above * above,
                 radius2 = finger.radius * finger.radius;
    if (off2 >= radius2)
        return kNowhere;
    if (shape_ == FingertipShape::sphere)
        return above + std::sqrt(radius2 - off2);
    const double all = place.rest_depth + pulse.dot(place.normal);
    if (shape_ == FingertipShape::held)
        return std::max(all, 0.0);
    const double share = off2 / radius2, share4 = share * share * share * share;
    return all * (1.0 - share4 * share4 * share4);
}

std::size_t FingertipSearch::candidates(const Fingertip& finger, const TouchedPlace& place,
    const ContactNodeCompliance& body, double pressure, std::vector<Candidate>& into, std::size_t most,
    int& missing) noexcept
{
    RETRACTOR_ASSERT(0 < most && most <= into.size() && place.vertex >= 0);
    std::size_t found = 0, first = 0, last = 0;
    missing = 0;
    const auto look_at = [&](std::int32_t contact_node) {
        const auto s = static_cast<std::size_t>(contact_node);
        if (seen_[s] == search_ || last == kMostSeen)
            return;
        seen_[s] = search_;
        queue_[last++] = contact_node;
    };
    ++search_;
    if (const std::int32_t s = surface_->contact_node_of(place.vertex); s >= 0)
        look_at(s);
    for (const std::int32_t v : surface_->neighbours().of(static_cast<std::size_t>(place.vertex)))
        if (const std::int32_t s = surface_->contact_node_of(v); s >= 0)
            look_at(s);
    // A contact node with a negative demand may still press, because others push it out. A rim of one spacing is kept.
    const double reach = std::min(finger.radius, surface_->spacing());
    for (; first < last; ++first) {
        const double wanted = demand(finger, place, queue_[first], body, pressure);
        if (wanted < -reach)
            continue;
        for (const std::int32_t next : surface_->contact_node_neighbours().of(static_cast<std::size_t>(queue_[first])))
            look_at(next);
        if (!body.ready(queue_[first])) {
            missing += wanted > 0.0 ? 1 : 0;
            continue;
        }
        std::size_t at = found < most ? found++ : most;
        if (at == most) {
            if (wanted <= into[most - 1].demand)
                continue;
            at = most - 1;
        }
        for (; at > 0 && into[at - 1].demand < wanted; --at)
            into[at] = into[at - 1];
        into[at] = { queue_[first], wanted };
    }
    return found;
}

} // namespace retractor::haptics
