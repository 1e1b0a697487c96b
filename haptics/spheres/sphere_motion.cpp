#include "haptics/spheres/sphere_motion.h"

#include "haptics/condensed/sneddon.h"
#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace retractor::haptics {

namespace {

    constexpr double kStill = 1e-4; // mm; a smaller displacement counts as zero

    void check(const std::vector<SphereOrgan>& organs, const SphereLaw& law)
    {
        if (organs.empty())
            throw InputError("a sphere-filled scene needs an organ");
        if (law.depth_limit < 1 || law.depth_limit > 250)
            throw InputError("the depth limit is 1 to 250 layers, got " + std::to_string(law.depth_limit));
        if (!(law.transmission > 0.0 && law.transmission <= SphereMotion::kMostTransmission))
            throw InputError("the transmission lies above 0 and up to 0.8, got " + std::to_string(law.transmission));
        if (!(law.recovery_time > 0.0) || !std::isfinite(law.recovery_time))
            throw InputError("the recovery time must be positive, got " + std::to_string(law.recovery_time));
        if (law.fingers < 1 || law.fingers > SphereMotion::kMostFingers)
            throw InputError("spheres are touched by 1 to 6 fingers, got " + std::to_string(law.fingers));
        for (const SphereOrgan& organ : organs) {
            if (organ.filling.count() == 0)
                throw InputError("the organ has no spheres", organ.name);
            if (!(organ.stiffness > 0.0) || !std::isfinite(organ.stiffness))
                throw InputError(
                    "the organ's stiffness must be positive, got " + std::to_string(organ.stiffness), organ.name);
        }
    }

    Vec3 at(const Points& points, std::int32_t i) { return points.row(i).transpose(); }

} // namespace

SphereMotion::SphereMotion(std::vector<SphereOrgan> organs, const SphereLaw& law)
    : organs_(std::move(organs))
    , law_(law)
{
    check(organs_, law);
    std::size_t count = 0, vertices = 0;
    for (const SphereOrgan& organ : organs_) {
        count += organ.filling.count();
        vertices += static_cast<std::size_t>(organ.surface.vertices.rows());
        largest_radius_ = std::max(largest_radius_, organ.filling.radius);
    }
    rest_.resize(static_cast<Eigen::Index>(count), 3);
    surface_.vertices.resize(static_cast<Eigen::Index>(vertices), 3);
    first_.push_back(0);
    Eigen::Index sphere = 0, vertex = 0;
    for (std::size_t o = 0; o < organs_.size(); ++o) {
        const SphereOrgan& organ = organs_[o];
        RETRACTOR_ASSERT(organ.filling.reach.size() == organ.filling.count());
        RETRACTOR_ASSERT(organ.filling.first.size() == organ.filling.count() + 1);
        rest_.middleRows(sphere, organ.filling.centres.rows()) = organ.filling.centres;
        for (std::size_t i = 0; i < organ.filling.count(); ++i) {
            organ_of_.push_back(static_cast<std::uint32_t>(o));
            reach_.push_back(organ.filling.reach[i]);
            largest_reach_ = std::max(largest_reach_, organ.filling.reach[i]);
            for (const std::int32_t j : organ.filling.of(i))
                neighbours_.push_back(j + static_cast<std::int32_t>(sphere));
            first_.push_back(static_cast<std::int32_t>(neighbours_.size()));
        }
        surface_.vertices.middleRows(vertex, organ.surface.vertices.rows()) = organ.surface.vertices;
        for (auto triangle : organ.surface.triangles) {
            for (VertexId& v : triangle)
                v += static_cast<VertexId>(vertex);
            surface_.triangles.push_back(triangle);
            surface_.labels.push_back(static_cast<Label>(o + 1));
        }
        sphere += organ.filling.centres.rows();
        vertex += organ.surface.vertices.rows();
    }
    RETRACTOR_ASSERT(organ_of_.size() == count && sphere == rest_.rows());
    now_ = rest_;
    layer_.assign(count, kUntouched);
    owner_.assign(count, 0);
    asked_.assign(3 * count, 0.0);
    askers_.assign(count, 0);
    is_displaced_.assign(count, 0);
    for (auto* list : { &frontier_, &next_frontier_, &displaced_, &grid_items_, &grid_at_ })
        list->assign(count, 0);
    last_.assign(law.fingers, Vec3::Zero());
    pinches_.assign(law.fingers, {});

    grid_cell_ = 2.0 * largest_radius_;
    const double margin = 4.0 * grid_cell_;
    grid_low_ = rest_.colwise().minCoeff().transpose().array() - margin;
    const Vec3 extent = (rest_.colwise().maxCoeff().transpose().array() + margin).matrix() - grid_low_;
    std::size_t cells = 1;
    for (std::size_t i = 0; i < 3; ++i) {
        grid_size_[i] = 1 + static_cast<int>(extent(static_cast<Eigen::Index>(i)) / grid_cell_);
        cells *= static_cast<std::size_t>(grid_size_[i]);
    }
    grid_first_.assign(cells + 1, 0);
    build_grid();
    Eigen::Index row = 0;
    for (std::size_t o = 0; o < organs_.size(); ++o)
        for (Eigen::Index v = 0; v < organs_[o].surface.vertices.rows(); ++v)
            bindings_.push_back(bind(surface_.vertices.row(row++).transpose(), o));
}

/// Finds the four spheres of the organ that are nearest at rest.
SphereMotion::Binding SphereMotion::bind(const Vec3& rest, std::size_t organ) const
{
    RETRACTOR_ASSERT(organ < organs_.size());
    std::array<std::pair<double, std::int32_t>, 4> nearest;
    nearest.fill({ std::numeric_limits<double>::infinity(), -1 });
    for (double reach = 2.0 * grid_cell_; nearest[3].second < 0 && reach < 1e3 * grid_cell_; reach *= 2.0) {
        nearest.fill({ std::numeric_limits<double>::infinity(), -1 });
        // The grid may contain displaced spheres, so the search is a little wider than the accepted distance at rest.
        near(rest, reach, [&](std::int32_t i) {
            if (organ_of_[static_cast<std::size_t>(i)] != organ)
                return;
            const std::pair<double, std::int32_t> entry { (at(rest_, i) - rest).norm(), i };
            for (std::size_t k = 0; k < 4; ++k)
                if (entry < nearest[k]) {
                    std::move_backward(
                        nearest.begin() + static_cast<std::ptrdiff_t>(k), nearest.end() - 1, nearest.end());
                    nearest[k] = entry;
                    break;
                }
        });
        if (organs_[organ].filling.count() < 4 && nearest[organs_[organ].filling.count() - 1].second >= 0)
            break;
    }
    Binding binding;
    double sum = 0.0;
    for (std::size_t k = 0; k < 4; ++k) {
        const bool exists = nearest[k].second >= 0;
        binding.sphere[k] = exists ? nearest[k].second : nearest[0].second;
        binding.weight[k] = exists ? 1.0 / std::max(1e-6, nearest[k].first * nearest[k].first) : 0.0;
        sum += binding.weight[k];
    }
    for (double& weight : binding.weight)
        weight /= sum;
    return binding;
}

/// Counting sort of the spheres by cell. Spheres outside the grid belong to its outermost cells.
void SphereMotion::build_grid() noexcept
{
    std::fill(grid_first_.begin(), grid_first_.end(), 0);
    const double inverse = 1.0 / grid_cell_;
    for (Eigen::Index i = 0; i < now_.rows(); ++i) {
        std::int32_t cell = 0;
        for (Eigen::Index axis = 2; axis >= 0; --axis) {
            const auto size = grid_size_[static_cast<std::size_t>(axis)];
            const auto place = static_cast<std::int32_t>(
                std::clamp((now_(i, axis) - grid_low_(axis)) * inverse, 0.0, static_cast<double>(size) - 0.5));
            cell = cell * size + place;
        }
        grid_at_[static_cast<std::size_t>(i)] = cell;
        ++grid_first_[static_cast<std::size_t>(cell) + 1];
    }
    for (std::size_t c = 1; c < grid_first_.size(); ++c)
        grid_first_[c] += grid_first_[c - 1];
    // Goes from the last sphere down, so that the spheres of each cell are in rising order.
    for (Eigen::Index i = now_.rows() - 1; i >= 0; --i)
        grid_items_[static_cast<std::size_t>(
            --grid_first_[static_cast<std::size_t>(grid_at_[static_cast<std::size_t>(i)]) + 1])]
            = static_cast<std::int32_t>(i);
    // The loop used the entries above as ends; shift them back to starts.
    for (std::size_t c = 0; c + 1 < grid_first_.size(); ++c)
        grid_first_[c] = grid_first_[c + 1];
    grid_first_.back() = static_cast<std::int32_t>(now_.rows());
}

template <class Visit> void SphereMotion::near(const Vec3& p, double distance, Visit&& visit) const noexcept
{
    std::array<int, 3> from {}, to {};
    for (std::size_t i = 0; i < 3; ++i) {
        const auto axis = static_cast<Eigen::Index>(i);
        const double top = static_cast<double>(grid_size_[i]) - 0.5;
        from[i] = static_cast<int>(std::clamp((p(axis) - distance - grid_low_(axis)) / grid_cell_, 0.0, top));
        to[i] = static_cast<int>(std::clamp((p(axis) + distance - grid_low_(axis)) / grid_cell_, 0.0, top));
    }
    for (int z = from[2]; z <= to[2]; ++z)
        for (int y = from[1]; y <= to[1]; ++y) {
            const auto row = static_cast<std::size_t>((z * grid_size_[1] + y) * grid_size_[0]);
            const auto begin = grid_first_[row + static_cast<std::size_t>(from[0])];
            const auto end = grid_first_[row + static_cast<std::size_t>(to[0]) + 1];
            for (std::int32_t k = begin; k < end; ++k)
                visit(grid_items_[static_cast<std::size_t>(k)]);
        }
}

void SphereMotion::recover(double dt) noexcept
{
    const double kept = std::exp(-dt / law_.recovery_time);
    std::size_t still_displaced = 0;
    for (std::size_t k = 0; k < displaced_count_; ++k) {
        const std::int32_t i = displaced_[k];
        layer_[static_cast<std::size_t>(i)] = kUntouched;
        const Eigen::RowVector3d off = kept * (now_.row(i) - rest_.row(i));
        if (off.squaredNorm() < kStill * kStill) {
            now_.row(i) = rest_.row(i);
            is_displaced_[static_cast<std::size_t>(i)] = 0;
        } else {
            now_.row(i) = rest_.row(i) + off;
            displaced_[still_displaced++] = i;
        }
    }
    displaced_count_ = still_displaced;
}

void SphereMotion::claim(std::int32_t sphere, std::size_t finger, int layer) noexcept
{
    RETRACTOR_ASSERT(layer >= 0 && layer < kUntouched && finger < pinches_.size());
    const auto i = static_cast<std::size_t>(sphere);
    layer_[i] = static_cast<std::uint8_t>(layer);
    owner_[i] = static_cast<std::uint8_t>(finger);
    if (is_displaced_[i] == 0) {
        is_displaced_[i] = 1;
        displaced_[displaced_count_++] = sphere;
    }
}

void SphereMotion::touch(std::span<const Fingertip> fingers) noexcept
{
    RETRACTOR_ASSERT(fingers.size() <= pinches_.size());
    frontier_count_ = 0;
    for (std::size_t f = 0; f < fingers.size(); ++f) {
        if (pinches_[f].vertex >= 0) {
            for (std::size_t k = 0; k < 4; ++k) {
                const std::int32_t i = pinches_[f].sphere[k];
                if (layer_[static_cast<std::size_t>(i)] == 0)
                    continue; // the sphere is listed twice or belongs to another finger
                now_.row(i) = (fingers[f].position + pinches_[f].sphere_offset[k]).transpose();
                claim(i, f, 0);
                frontier_[frontier_count_++] = i;
            }
            continue;
        }
        const Vec3 centre = fingers[f].position;
        near(centre, fingers[f].radius + largest_reach_, [&](std::int32_t i) {
            const double reach = fingers[f].radius + reach_[static_cast<std::size_t>(i)];
            const Vec3 out = at(now_, i) - centre;
            const double distance = out.norm();
            if (distance >= reach || distance == 0.0)
                return;
            now_.row(i) = (centre + out * (reach / distance)).transpose();
            if (layer_[static_cast<std::size_t>(i)] == 0)
                return; // the sphere belongs to another finger: both fingers displace it, and it counts for the first
            claim(i, f, 0);
            frontier_[frontier_count_++] = i;
        });
    }
}

/// Sphere i of the frontier demands a displacement of sphere j.
void SphereMotion::ask(std::int32_t i, std::int32_t j, const Vec3& displacement) noexcept
{
    if (displacement.squaredNorm() < kStill * kStill)
        return;
    const auto k = static_cast<std::size_t>(j);
    for (std::size_t axis = 0; axis < 3; ++axis)
        asked_[3 * k + axis] += displacement(static_cast<Eigen::Index>(axis));
    const auto from = owner_[static_cast<std::size_t>(i)];
    if (askers_[k]++ == 0) {
        next_frontier_[next_count_++] = j;
        owner_[k] = from;
    } else
        owner_[k] = std::min(owner_[k], from);
}

void SphereMotion::propagate() noexcept
{
    const bool several = organs_.size() > 1;
    for (int layer = 0; layer < law_.depth_limit && frontier_count_ > 0; ++layer) {
        next_count_ = 0;
        for (std::size_t n = 0; n < frontier_count_; ++n) {
            const std::int32_t i = frontier_[n];
            const auto s = static_cast<std::size_t>(i);
            const Vec3 moved = at(now_, i) - at(rest_, i);
            for (std::int32_t k = first_[s]; k < first_[s + 1]; ++k) {
                const std::int32_t j = neighbours_[static_cast<std::size_t>(k)];
                if (layer_[static_cast<std::size_t>(j)] != kUntouched)
                    continue;
                const Vec3 along = (at(rest_, j) - at(rest_, i)) / (2.0 * radius_of(s));
                ask(i, j, law_.transmission * ((1.0 - kSpread) * moved + 2.0 * kSpread * along.dot(moved) * along));
            }
            if (!several)
                continue;
            near(at(now_, i), reach_[s] + largest_reach_, [&](std::int32_t j) {
                const auto other = static_cast<std::size_t>(j);
                if (organ_of_[other] == organ_of_[s] || layer_[other] != kUntouched)
                    return;
                const Vec3 apart = at(rest_, j) - at(rest_, i);
                const double at_rest = apart.norm();
                if (at_rest == 0.0)
                    return;
                const double gap = std::max(0.0, at_rest - reach_[s] - reach_[other]);
                const double push = apart.dot(moved) / at_rest - gap;
                if (push > 0.0)
                    ask(i, j, law_.transmission * push / at_rest * apart);
            });
        }
        for (std::size_t n = 0; n < next_count_; ++n) {
            const std::int32_t j = next_frontier_[n];
            const auto k = static_cast<std::size_t>(j);
            const double share = 1.0 / askers_[k];
            for (Eigen::Index axis = 0; axis < 3; ++axis) {
                now_(j, axis) = rest_(j, axis) + share * asked_[3 * k + static_cast<std::size_t>(axis)];
                asked_[3 * k + static_cast<std::size_t>(axis)] = 0.0;
            }
            askers_[k] = 0;
            claim(j, owner_[k], layer + 1);
        }
        std::swap(frontier_, next_frontier_);
        frontier_count_ = next_count_;
    }
}

void SphereMotion::measure(std::span<SphereContact> contacts) const noexcept
{
    for (SphereContact& contact : contacts)
        contact = {};
    for (std::size_t k = 0; k < displaced_count_; ++k) {
        const std::int32_t i = displaced_[k];
        const auto s = static_cast<std::size_t>(i);
        if (layer_[s] == kUntouched)
            continue; // on the way back to rest
        RETRACTOR_ASSERT(owner_[s] < contacts.size());
        SphereContact& contact = contacts[owner_[s]];
        const Vec3 displacement = at(now_, i) - at(rest_, i);
        contact.force -= organs_[organ_of_[s]].stiffness * displacement;
        const double depth = displacement.norm();
        if (!contact.touching || depth > contact.depth) {
            contact.depth = depth;
            contact.radius = radius_of(s);
        }
        ++contact.spheres;
        contact.touching = true;
    }
}

void SphereMotion::advance(double dt, std::span<const Fingertip> fingers, std::span<SphereContact> contacts) noexcept
{
    constexpr int kMostSteps = 8;
    double farthest = 0.0;
    for (std::size_t f = 0; f < fingers.size(); ++f) {
        if (!started_)
            last_[f] = fingers[f].position;
        farthest = std::max(farthest, (fingers[f].position - last_[f]).norm());
    }
    started_ = true;
    // Several sub-steps let a fast finger push spheres ahead instead of passing over them.
    const int steps = std::clamp(static_cast<int>(std::ceil(farthest / largest_radius_)), 1, kMostSteps);
    std::array<Fingertip, kMostFingers> on_the_way;
    for (int s = 1; s <= steps; ++s) {
        const double share = static_cast<double>(s) / steps;
        for (std::size_t f = 0; f < fingers.size(); ++f) {
            on_the_way[f] = fingers[f];
            on_the_way[f].position = last_[f] + share * (fingers[f].position - last_[f]);
        }
        recover(dt / steps);
        build_grid();
        touch({ on_the_way.data(), fingers.size() });
        propagate();
    }
    for (std::size_t f = 0; f < fingers.size(); ++f)
        last_[f] = fingers[f].position;
    measure(contacts);
}

void SphereMotion::deform(Points& deformed) const
{
    deformed.resize(surface_.vertices.rows(), 3);
    for (Eigen::Index v = 0; v < deformed.rows(); ++v) {
        const Binding& binding = bindings_[static_cast<std::size_t>(v)];
        Eigen::RowVector3d moved = surface_.vertices.row(v);
        for (std::size_t k = 0; k < 4; ++k)
            moved += binding.weight[k] * (now_.row(binding.sphere[k]) - rest_.row(binding.sphere[k]));
        deformed.row(v) = moved;
    }
    for (std::size_t f = 0; f < pinches_.size(); ++f)
        if (pinches_[f].vertex >= 0)
            deformed.row(pinches_[f].vertex) = (last_[f] + pinches_[f].offset).transpose();
}

VertexId SphereMotion::add_vertex(const NearestOnSurface& at_surface, std::size_t organ)
{
    const auto& corners = surface_.triangles[at_surface.triangle];
    Vec3 rest = Vec3::Zero();
    for (std::size_t i = 0; i < 3; ++i)
        rest += at_surface.weights(static_cast<Eigen::Index>(i)) * surface_.vertices.row(corners[i]).transpose();
    surface_.vertices.conservativeResize(surface_.vertices.rows() + 1, Eigen::NoChange);
    surface_.vertices.row(surface_.vertices.rows() - 1) = rest.transpose();
    bindings_.push_back(bind(rest, organ));
    return static_cast<VertexId>(surface_.vertices.rows() - 1);
}

/// Finds or creates a vertex at this place: an existing vertex, or a new vertex that divides the polygon into two or
/// three parts.
VertexId SphereMotion::divide_at(const NearestOnSurface& place)
{
    constexpr double kCorner = 1e-6; // weights; a place closer than this is the corner or lies on the edge
    const std::size_t t = place.triangle;
    const auto corners = surface_.triangles[t];
    for (std::size_t i = 0; i < 3; ++i)
        if (place.weights(static_cast<Eigen::Index>(i)) > 1.0 - kCorner)
            return corners[i];
    const Label label = surface_.labels[t];
    const VertexId made = add_vertex(place, static_cast<std::size_t>(label - 1));
    const auto add = [&](VertexId a, VertexId b, VertexId c) {
        surface_.triangles.push_back({ a, b, c });
        surface_.labels.push_back(label);
    };
    for (std::size_t i = 0; i < 3; ++i) {
        if (place.weights(static_cast<Eigen::Index>(i)) >= kCorner)
            continue;
        const VertexId a = corners[(i + 1) % 3], b = corners[(i + 2) % 3]; // the place lies on this edge
        surface_.triangles[t] = { corners[i], a, made };
        add(corners[i], made, b);
        for (std::size_t other = 0; other < surface_.triangles.size(); ++other) {
            const auto triangle = surface_.triangles[other];
            for (std::size_t k = 0; k < 3; ++k)
                if (triangle[k] == b && triangle[(k + 1) % 3] == a) {
                    surface_.triangles[other] = { triangle[(k + 2) % 3], b, made };
                    add(triangle[(k + 2) % 3], made, a);
                    return made;
                }
        }
        return made;
    }
    surface_.triangles[t] = { corners[0], corners[1], made };
    add(corners[1], corners[2], made);
    add(corners[2], corners[0], made);
    return made;
}

VertexId SphereMotion::pinch(std::size_t finger, const Fingertip& tip, double reach)
{
    if (finger >= pinches_.size())
        throw InputError("finger " + std::to_string(finger) + " does not exist");
    if (pinches(finger))
        throw InputError("finger " + std::to_string(finger) + " pinches already");
    Points deformed;
    deform(deformed);
    const NearestOnSurface place = nearest_on_surface(tip.position, deformed, surface_.triangles);
    if (place.distance > tip.radius + reach)
        throw InputError("no surface within " + std::to_string(reach) + " mm of finger " + std::to_string(finger));
    Pinch pinch;
    pinch.vertex = divide_at(place);
    pinch.offset = place.point - tip.position;
    pinch.sphere = bindings_[static_cast<std::size_t>(pinch.vertex)].sphere;
    for (std::size_t k = 0; k < 4; ++k)
        pinch.sphere_offset[k] = at(now_, pinch.sphere[k]) - tip.position;
    pinches_[finger] = pinch;
    return pinch.vertex;
}

void SphereMotion::release(std::size_t finger) noexcept { pinches_[finger] = {}; }

double calibrate_sphere_force(double sphere_radius, const SphereLaw& law, double youngs_modulus_MPa,
    double poissons_ratio, double finger_radius, double depth)
{
    if (!(youngs_modulus_MPa > 0.0) || !(poissons_ratio > -1.0 && poissons_ratio < 0.5))
        throw InputError("a half-space needs a positive Young's modulus and a Poisson's ratio between -1 and 0.5");
    if (!(finger_radius > 0.0) || !(depth > 0.0))
        throw InputError("the finger's radius and the depth must be positive");
    // The block is wide and deep enough that the depth limit ends the motion and not the block; beyond kTail layers no
    // motion is left.
    constexpr int kTail = 24;
    const double half = 2.0 * sphere_radius * (std::min(law.depth_limit, kTail) + 2) + 2.0 * finger_radius;
    TriMesh box;
    box.vertices.resize(8, 3);
    for (int v = 0; v < 8; ++v)
        box.vertices.row(v) << ((v & 1) != 0 ? half : -half), ((v & 2) != 0 ? half : -half),
            ((v & 4) != 0 ? 0.0 : -half);
    box.triangles = { { 0, 2, 1 }, { 1, 2, 3 }, { 4, 5, 6 }, { 5, 7, 6 }, { 0, 1, 4 }, { 1, 5, 4 }, { 2, 6, 3 },
        { 3, 6, 7 }, { 0, 4, 2 }, { 2, 4, 6 }, { 1, 3, 5 }, { 3, 7, 5 } };
    SphereLaw one = law;
    one.fingers = 1;
    SphereFilling filling = fill_with_spheres(box, sphere_radius);
    constexpr double top = 0.0; // the outer spheres reach the face of the block
    SphereMotion motion({ { "block", box, std::move(filling), 1.0 } }, one);
    Fingertip tip { Vec3(0.0, 0.0, top + finger_radius), Vec3::Zero(), finger_radius };
    SphereContact contact;
    constexpr int kSteps = 40;
    for (int i = 1; i <= 2 * kSteps; ++i) { // down, and then until the force is constant
        tip.position.z() = top + finger_radius - depth * std::min(1.0, static_cast<double>(i) / kSteps);
        motion.advance(1.0 / 60.0, { &tip, 1 }, { &contact, 1 });
    }
    return sneddon_force(depth, finger_radius, youngs_modulus_MPa, poissons_ratio) / contact.force.z();
}

} // namespace retractor::haptics
