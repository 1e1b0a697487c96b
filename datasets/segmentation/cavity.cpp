#include "datasets/segmentation/cavity.h"

#include "datasets/segmentation/diaphragm.h"
#include "datasets/segmentation/midline.h"
#include "datasets/segmentation/polar_surface.h"
#include "mesh/base/statistics.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace retractor::datasets::segmentation {

namespace {

    constexpr float kNone = -1.0F;

    /// Distances (mm) from the axis to the tissues on a ray; kNone for a tissue that the ray does not meet.
    struct Sightings {
        PolarField lung; ///< last voxel of lung
        PolarField bone; ///< first voxel of the rib cage
        PolarField muscle; ///< inner face of the fat under the skin
        PolarField skin; ///< the end of the body

        explicit Sightings(int planes)
            : lung(planes, kNone)
            , bone(planes, kNone)
            , muscle(planes, kNone)
            , skin(planes, kNone)
        {
        }
    };

    /// An axis in the middle of the lungs, and well in front of the spine.
    PolarAxis axis_of(const CavityInput& input, std::vector<double>& front_y)
    {
        constexpr double kSmoothing = 20.0; // mm
        constexpr double kBeforeSpine = 14.0;
        const Extent extent = input.image.extent();
        const int reach = static_cast<int>(kSmoothing / extent.spacing[2]);
        const std::vector<PlaneExtents> lungs = plane_extents(extent, input.lungs.both());
        const std::vector<PlaneExtents> spine = plane_extents(extent, input.spine);
        PolarAxis axis;
        for (std::size_t k = 0; k < lungs.size(); ++k) {
            const PlaneExtents& l = lungs[k];
            const PlaneExtents& s = spine[k];
            axis.x.push_back(!s.empty() ? 0.5 * (s.low_x + s.high_x)
                    : l.empty()         ? std::nan("")
                                        : 0.5 * (l.low_x + l.high_x));
            axis.y.push_back(l.empty() ? std::nan("") : 0.5 * (l.low_y + l.high_y));
        }
        axis.x = smooth_line(axis.x, reach);
        axis.y = smooth_line(axis.y, reach);
        front_y = smooth_line(spine_front(extent, input.spine, axis.x), reach / 4);
        for (std::size_t k = 0; k < axis.y.size(); ++k)
            if (!std::isnan(front_y[k]))
                axis.y[k] = std::min(axis.y[k], front_y[k] - kBeforeSpine / extent.spacing[1]);
        return axis;
    }

    void look_along_ray(const CavityInput& input, const PolarAxis& axis, int angle, int k,
        std::vector<std::uint8_t>& seen, Sightings& s)
    {
        constexpr double kStep = 0.75;
        constexpr double kSkin = 3.0;
        constexpr int kFatLow = -250;
        constexpr int kFatHigh = -30;
        constexpr double kSureMuscle = 4.5; // a stretch without fat of this length is muscle, not a septum
        const Extent extent = input.image.extent();
        const double turn = 2.0 * std::numbers::pi * angle / kAngles;
        const double dx = std::sin(turn) * kStep / extent.spacing[0];
        const double dy = std::cos(turn) * kStep / extent.spacing[1];
        const std::size_t at = PolarField::offset(angle, k);
        seen.clear(); // one entry per step: fat or not
        for (int n = 0;; ++n) {
            const int i = static_cast<int>(std::lround(axis.x[static_cast<std::size_t>(k)] + n * dx));
            const int j = static_cast<int>(std::lround(axis.y[static_cast<std::size_t>(k)] + n * dy));
            if (!input.image.grid.contains(i, j, k))
                break;
            const std::size_t v = input.image.grid.offset(i, j, k);
            if (input.body[v] == 0)
                break;
            const auto r = static_cast<float>(n * kStep);
            if (input.lungs.left[v] != 0 || input.lungs.right[v] != 0)
                s.lung.values[at] = r;
            if (input.cage[v] != 0 && s.bone.values[at] < 0.0F)
                s.bone.values[at] = r;
            seen.push_back(input.image.hu[v] < kFatHigh && input.image.hu[v] > kFatLow ? 1 : 0);
        }
        const auto skin = static_cast<float>(static_cast<double>(seen.size()) * kStep);
        s.skin.values[at] = skin;
        double muscle = 0.0;
        for (std::size_t n = seen.size(); n-- > 0;) {
            if ((static_cast<double>(seen.size() - n)) * kStep < kSkin)
                continue;
            muscle = seen[n] != 0 ? 0.0 : muscle + kStep;
            if (muscle >= kSureMuscle) {
                s.muscle.values[at] = static_cast<float>((static_cast<double>(n)) * kStep + kSureMuscle);
                break;
            }
        }
    }

    Sightings look(const CavityInput& input, const PolarAxis& axis, int threads)
    {
        const int planes = input.image.grid.size[2];
        Sightings s(planes);
        for_planes(planes, threads, [&](int k) {
            std::vector<std::uint8_t> seen;
            for (int angle = 0; angle < kAngles; ++angle)
                look_along_ray(input, axis, angle, k, seen, s);
        });
        return s;
    }

    /// The median over a neighbourhood. A gap between two muscles must not open a way into the abdomen.
    PolarField median_field(const PolarField& field, int angles, int planes, int threads)
    {
        PolarField out(field.planes, kNone);
        for_planes(field.planes, threads, [&](int k) {
            std::vector<float> values;
            for (int a = 0; a < kAngles; ++a) {
                values.clear();
                for (int dk = -planes; dk <= planes; ++dk)
                    for (int da = -angles; da <= angles; da += 2) {
                        const int plane = std::clamp(k + dk, 0, field.planes - 1);
                        const float value = field.values[PolarField::offset((a + da + kAngles) % kAngles, plane)];
                        if (value > 0.0F)
                            values.push_back(value);
                    }
                if (!values.empty())
                    out.values[PolarField::offset(a, k)] = upper_median(values);
            }
        });
        return out;
    }

    /// Computes the inner surface of the wall in two passes. The first pass uses bone, and gives a cage that shows
    /// whether a lung touches the wall. The second pass uses lung at places where the lung touches the wall, and bone
    /// elsewhere.
    PolarField inner_surface(const CavityInput& input, const Sightings& s, double spacing, int threads)
    {
        constexpr int kMuscleAngles = 16; // 12 degrees to each side
        constexpr int kMusclePlanes = 2;
        constexpr float kCover = 2.0F; // pleura and fascia inside bone
        constexpr float kOnWall = 12.0F; // lung within this distance of the cage touches the wall
        constexpr float kOnWallAlone = 28.0F; // the same distance at places without bone nearby
        constexpr float kAbdominalMuscle = 12.0F;
        constexpr float kFarFromBone = 20.0F;
        constexpr float kNearBone = 14.0F; // half the widest space between ribs
        constexpr float kLeastWall = 6.0F; // least thickness of the wall under the skin
        constexpr double kApex = 40.0; // mm; in this part the dome leaves the ribs, and only the lung shows the dome
        const Extent extent = input.image.extent();
        const int planes = extent.size[2];
        const PolarField muscle = median_field(s.muscle, kMuscleAngles, kMusclePlanes, threads);
        const auto [lung_low, lung_high] = plane_range(plane_extents(extent, input.lungs.both()));
        const auto [sternum_low, sternum_high] = plane_range(plane_extents(extent, input.sternum));
        const int abdomen_high = sternum_low >= 0 ? sternum_low : (lung_low + lung_high) / 2;

        std::vector<std::uint8_t> known(s.bone.values.size(), 0);
        PolarField cage = s.bone;
        for (std::size_t n = 0; n < known.size(); ++n)
            known[n] = s.bone.values[n] > 0.0F ? 1 : 0;
        const std::vector<float> from_bone
            = distance_to({ { kAngles, planes, 1 }, { 2.0, spacing, 1.0 } }, Mask(known.begin(), known.end()));
        for (int k = 0; k < std::min(abdomen_high, planes); ++k)
            for (int a = 0; a < kAngles; ++a) {
                const std::size_t n = PolarField::offset(a, k);
                if (known[n] == 0 && muscle.values[n] > 0.0F && from_bone[n] > kFarFromBone) {
                    cage.values[n] = muscle.values[n] - kAbdominalMuscle;
                    known[n] = 1;
                }
            }
        complete(cage, known);

        PolarField radius = cage;
        for (int k = 0; k < planes; ++k)
            for (int a = 0; a < kAngles; ++a) {
                const std::size_t n = PolarField::offset(a, k);
                const float lung = s.lung.values[n];
                const bool apex = (lung_high - k) * spacing < kApex;
                const float on_wall = from_bone[n] > kNearBone ? kOnWallAlone : kOnWall;
                if (lung > 0.0F && (apex || cage.values[n] - lung < on_wall)
                    && !(s.bone.values[n] > 0.0F && s.bone.values[n] < lung)) {
                    radius.values[n] = lung + 0.5F * static_cast<float>(spacing);
                    known[n] = 1;
                } else if (s.bone.values[n] > 0.0F) {
                    radius.values[n] = s.bone.values[n] - kCover;
                    known[n] = 1;
                } else if (known[n] == 0) {
                    radius.values[n] = kNone;
                }
            }
        complete(radius, known);
        for (std::size_t n = 0; n < known.size(); ++n)
            radius.values[n] = std::max(0.0F, std::min(radius.values[n], s.skin.values[n] - kLeastWall));
        return radius;
    }

    /// The neck lies above the plane through the sternum's upper end and the back of the lungs' tops. Returns the
    /// highest plane index for each y.
    std::vector<int> inlet(const CavityInput& input, const std::vector<double>& front_y)
    {
        constexpr double kDrop = 35.0; // mm from the lungs' tops down to the front, when no sternum is found
        const Extent extent = input.image.extent();
        const int apex = plane_range(plane_extents(extent, input.lungs.both())).second;
        const std::vector<PlaneExtents> sternum = plane_extents(extent, input.sternum);
        const int notch = plane_range(sternum).second;
        const std::vector<PlaneExtents> lungs = plane_extents(extent, input.lungs.both());
        const double back = std::isnan(front_y[static_cast<std::size_t>(apex)])
            ? lungs[static_cast<std::size_t>(apex)].high_y
            : front_y[static_cast<std::size_t>(apex)];
        const double front
            = notch >= 0 ? sternum[static_cast<std::size_t>(notch)].high_y : back - 60.0 / extent.spacing[1];
        const double low = notch >= 0 ? std::min(notch, apex) : apex - kDrop / extent.spacing[2];
        std::vector<int> limit;
        for (int j = 0; j < extent.size[1]; ++j) {
            const double t = back > front ? std::clamp((j - front) / (back - front), 0.0, 1.0) : 1.0;
            limit.push_back(static_cast<int>(std::lround(low + t * (apex - low))));
        }
        return limit;
    }

    void cut_above(const Extent& extent, const std::vector<int>& limit, Mask& mask)
    {
        std::size_t v = 0;
        for (int k = 0; k < extent.size[2]; ++k)
            for (int j = 0; j < extent.size[1]; ++j)
                for (int i = 0; i < extent.size[0]; ++i, ++v)
                    if (k > limit[static_cast<std::size_t>(j)])
                        mask[v] = 0;
    }

} // namespace

Cavity segment_cavity(const CavityInput& input, int threads)
{
    const Extent extent = input.image.extent();
    std::vector<double> front_y;
    const PolarAxis axis = axis_of(input, front_y);
    const Sightings sightings = look(input, axis, threads);
    PolarField radius = inner_surface(input, sightings, extent.spacing[2], threads);
    constexpr float kShell = 10.0F;
    Mask inside = inside_surface(extent, axis, radius, input.body, threads);
    inside = united(inside, input.lungs.trachea);
    cut_above(extent, inlet(input, front_y), inside);
    const Mask lungs = input.lungs.both();
    inside = united(majority(extent, without(united(inside, lungs), input.bones), 1, threads), lungs);
    inside = largest_piece(extent, without(inside, input.bones));

    Cavity cavity;
    for (float& r : radius.values)
        r += kShell;
    cavity.shell = inside_surface(extent, axis, radius, input.body, threads);
    const DiaphragmHeight diaphragm = diaphragm_height(extent, input.lungs);
    if (!diaphragm.seen)
        cavity.warnings.emplace_back("the diaphragm is not in view: no upper abdomen");
    cavity.thorax.assign(inside.size(), 0);
    cavity.abdomen.assign(inside.size(), 0);
    std::size_t v = 0;
    for (int k = 0; k < extent.size[2]; ++k)
        for (std::size_t column = 0; column < diaphragm.plane.size(); ++column, ++v)
            if (inside[v] != 0)
                (lungs[v] != 0 || k > diaphragm.plane[column] ? cavity.thorax : cavity.abdomen)[v] = 1;
    return cavity;
}

} // namespace retractor::datasets::segmentation
