#pragma once
// The steps of segment_bones() and what they hand to one another. Not part of the public interface. mm, HU, patient
// LPS; the working grid's axes are those of the patient, so x is left, y is back, z is up, per voxel.

#include "datasets/segmentation/bones/bones_input.h"
#include "datasets/segmentation/image/image_filters.h"
#include "mesh/base/job.h"
#include "mesh/image/volume.h"

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <utility>
#include <vector>

namespace retractor::datasets::segmentation {

using Voxel = std::size_t; ///< offset into the working grid

/// The image averaged over blocks of about 3 mm: enough for landmarks, and quick.
struct CoarseImage {
    mesh::ImageGrid grid;
    int factor = 1; ///< working voxels per coarse voxel, along each axis
    std::vector<std::int16_t> hu;
    Mask body, lungs;

    Extent extent() const { return { grid.size, { grid.spacing.x(), grid.spacing.y(), grid.spacing.z() } }; }
};
CoarseImage coarsened(const BonesInput& input);

/// A line through the slices: where a midline bone lies at each height.
struct MidlinePath {
    std::vector<Eigen::Vector2d> at; ///< per coarse slice: x, y (mm)
    int first = 0, last = -1; ///< slices in which the bone is seen; positions beyond are carried on from there
    double z0 = 0.0, dz = 1.0; ///< height of slice 0, distance of slices

    bool found() const { return last > first; }
    Eigen::Vector2d operator()(double z) const;
    double bottom() const { return z0 + dz * first; }
    double top() const { return z0 + dz * last; }
};
/// The middle of the vertebral bodies. Not found: first > last.
MidlinePath find_spine(const CoarseImage& image);
/// The middle of the breastbone, in front of the spine.
MidlinePath find_sternum(const CoarseImage& image, const MidlinePath& spine);
/// The paths of bones that are labelled already.
MidlinePath path_of_label(const CoarseImage& image, const mesh::LabelVolume& labels, Label label);

/// Where the rib cage is: round the convex hulls of the lungs, slice by slice.
struct Cage {
    mesh::ImageGrid grid; ///< coarse
    std::vector<float> outside; ///< mm from the hull, negative inside
    MidlinePath spine, sternum;
    std::vector<double> vertebra_half_width; ///< mm, per coarse slice
    double widest_z = 0.0; ///< height of the largest section of the lungs

    /// Middle of the chest between spine and sternum at a height.
    Eigen::Vector2d centre(double z) const;
    /// Half the width of the vertebral body.
    double half_width(double z) const;
    /// How far outside the hull ribs reach: 8 mm of rib over 3 of pleura and muscle, the scapula comes next; more
    /// below the lungs, where the hull is a guess and no scapula is.
    double rib_limit(double z) const;
    /// Degrees round the middle: 0 back, 90 side, 180 front; positive x is left.
    double angle(const Vec3& p) const;
    /// Mm outside the hull, trilinear is not needed: nearest coarse voxel.
    double outside_at(const Vec3& p) const;
};
Cage make_cage(const CoarseImage& image, const MidlinePath& spine, const MidlinePath& sternum);

/// Solid bone on the working grid: cortex by threshold, marrow filled; contrast in the cavity left out.
Mask bone_mask(const BonesInput& input, const Cage& cage, const std::vector<std::int16_t>& smooth_hu);

/// Where spine and sternum may be, and where they surely are (relative to their paths).
bool in_spine_core(const Cage& cage, const Vec3& p);
bool in_spine_reach(const Cage& cage, const Vec3& p);
bool in_sternum_core(const Cage& cage, const Vec3& p);
bool in_sternum_reach(const Cage& cage, const Vec3& p);

/// One rib as found: its voxels (seeds for the split), the centres of its pieces from the spine forwards.
struct RibTrack {
    bool left = true;
    int number = 0; ///< 0: not known
    std::vector<Vec3> line;
    std::vector<Voxel> voxels;
    std::vector<double> angle; ///< per point of the line, as Cage::angle, increasing
    double bridged_mm = 0.0; ///< longest gap that was closed
};
/// Follows the bone round the rib cage from the spine forwards, in sectors of a few degrees.
std::vector<RibTrack> track_ribs(const WorkingImage& image, const Mask& bone, const Cage& cage);
/// Sorts from top to bottom per side and sets the numbers; explains itself in `warnings`.
void number_ribs(
    std::vector<RibTrack>& ribs, const Cage& cage, const mesh::ImageGrid& grid, std::vector<std::string>& warnings);

/// Seeds grow over the bone, brightest voxels first, so that they meet in the dark seams (joints) between bones.
/// @param labels in: seeds; out: every voxel of `bone` that was reached. @param may_enter label, voxel -> allowed
void grow_seeds(const WorkingImage& image, const Mask& bone, const std::vector<std::int16_t>& smooth_hu,
    std::vector<Label>& labels, const std::function<bool(Label, Voxel)>& may_enter);

/// Fills a bone (closing of 2 mm, then holes of the sections), runs a thin tube along its line, keeps the largest
/// piece. Voxels of other bones are left alone, but the tube takes those of `yielding` ones.
void make_solid(const mesh::ImageGrid& grid, std::vector<Label>& labels, Label label,
    const std::vector<Vec3>& line = {}, const std::vector<Label>& yielding = {});
/// All but the largest piece of each of these becomes `rest`.
void keep_largest_pieces(
    const mesh::ImageGrid& grid, std::vector<Label>& labels, const std::vector<Label>& which, Label rest);

/// Takes from the bones that give way every voxel next to (over corners too, if asked) a bone they must be parted from.
void part_bones(const mesh::ImageGrid& grid, std::vector<Label>& labels, const std::vector<Label>& giving_way,
    bool corners, const std::function<bool(Label, Label)>& must_part);

/// Ids of the shoulder girdle while it is built.
struct GirdleIds {
    std::array<Label, 2> scapula {}, clavicle {}; ///< left, right
    Label other = 0;
};
/// @param not_rib the bone that is no rib: where it spreads, the clavicle has ended.
/// Labels a clavicle's core, of voxels that have no label or `other`. Returns points of its middle line, none when
/// there is no clavicle to be seen.
std::vector<Vec3> seed_clavicle(const mesh::ImageGrid& grid, const Mask& bone, const Cage& cage, bool left, Label other,
    Label clavicle, const Mask& not_rib, std::vector<Label>& labels);
/// Labels what bone is left: shoulder blades, clavicles, the rest.
void label_girdle(const WorkingImage& image, const Mask& bone, const Cage& cage, const GirdleIds& ids, Label cartilage,
    std::vector<Label>& labels);

/// The cartilage of one rib; an empty line when the rib's end or the way from it was not found.
struct CartilagePath {
    bool left = true;
    int number = 0;
    std::vector<Vec3> line = {};
    double seen = 0.0; ///< share of the path where the image shows cartilage
};
/// Labels the costal cartilages of ribs 1 to 10, after the other bones (only unlabelled voxels are taken).
std::vector<CartilagePath> add_cartilages(const WorkingImage& image, const CoarseImage& coarse, const Cage& cage,
    const Mask& bone, const std::vector<std::int16_t>& smooth_hu, const std::vector<RibTrack>& ribs, Label sternum,
    Label cartilage, std::vector<Label>& labels);

} // namespace retractor::datasets::segmentation
