#pragma once
// The steps of segment_bones(), and the data that pass between them. Not part of the public interface. Units mm and HU;
// patient LPS. The axes of the working grid are the patient's: x is left, y is back, z is up.

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

/// The image averaged over blocks of about 3 mm, for a quick search of landmarks.
struct CoarseImage {
    mesh::ImageGrid grid;
    int factor = 1; ///< working voxels per coarse voxel, along each axis
    std::vector<std::int16_t> hu;
    Mask body, lungs; ///< set where at least half of the block is set

    Extent extent() const { return { grid.size, { grid.spacing.x(), grid.spacing.y(), grid.spacing.z() } }; }
};
/// Averages the working image over blocks.
CoarseImage coarsened(const BonesInput& input);

/// The positions of a midline bone over the height, as a line through the slices.
struct MidlinePath {
    std::vector<Eigen::Vector2d> at; ///< per coarse slice: x, y (mm)
    int first = 0, last = -1; ///< slices that show the bone; positions beyond are extrapolated
    double z0 = 0.0, dz = 1.0; ///< height of slice 0, distance of slices (mm)

    bool found() const { return last > first; }
    /// Position (mm) at height z, interpolated between slices, or extrapolated beyond the bone.
    Eigen::Vector2d operator()(double z) const;
    double bottom() const { return z0 + dz * first; }
    double top() const { return z0 + dz * last; }
};
/// The path of the vertebral bodies' middle. The path is not found() when the image shows no spine.
MidlinePath find_spine(const CoarseImage& image);
/// The path of the breastbone's middle, in front of the spine.
MidlinePath find_sternum(const CoarseImage& image, const MidlinePath& spine);
/// The path of a bone that has a given label.
MidlinePath path_of_label(const CoarseImage& image, const mesh::LabelVolume& labels, Label label);

/// The place of the rib cage, around the convex hulls of the lungs in each slice.
struct Cage {
    mesh::ImageGrid grid; ///< coarse grid
    std::vector<float> outside; ///< distance from the hull per coarse voxel, mm; negative inside
    MidlinePath spine, sternum;
    std::vector<double> vertebra_half_width; ///< mm, per coarse slice
    double widest_z = 0.0; ///< height of the slice with the largest section of the lungs, mm

    /// Point midway between spine and sternum at a height, mm.
    Eigen::Vector2d centre(double z) const;
    /// Half the width of the vertebral body at a height, mm.
    double half_width(double z) const;
    /// Largest distance of a rib outside the hull (mm): 8 mm of rib over 3 mm of pleura and muscle, because the scapula
    /// lies next. The distance is larger below the lungs, where the hull is a guess and no scapula is near.
    double rib_limit(double z) const;
    /// Angle of a point about the centre (degrees): 0 back, 90 side, 180 front, on both sides of the body.
    double angle(const Vec3& p) const;
    /// Distance of a point outside the hull (mm), from the nearest coarse voxel; a finer interpolation is not needed.
    double outside_at(const Vec3& p) const;
};
/// Makes the cage and measures the vertebral bodies.
Cage make_cage(const CoarseImage& image, const MidlinePath& spine, const MidlinePath& sternum);

/// Solid bone on the working grid: cortex by threshold, with the marrow filled, without contrast in the cavity.
Mask bone_mask(const BonesInput& input, const Cage& cage, const std::vector<std::int16_t>& smooth_hu);

/// Regions relative to the paths of spine and sternum: the core surely belongs to the bone, the reach may belong to the
/// bone.
bool in_spine_core(const Cage& cage, const Vec3& p);
bool in_spine_reach(const Cage& cage, const Vec3& p);
bool in_sternum_core(const Cage& cage, const Vec3& p);
bool in_sternum_reach(const Cage& cage, const Vec3& p);

/// One rib that was followed.
struct RibTrack {
    bool left = true;
    int number = 0; ///< 1 to 12; 0: not known
    std::vector<Vec3> line; ///< centres of the rib's pieces from the spine forwards, mm
    std::vector<Voxel> voxels; ///< seeds of the rib for grow_seeds()
    std::vector<double> angle; ///< Cage::angle() of each point of the line, increasing
    double bridged_mm = 0.0; ///< longest gap between pieces, mm
};
/// Follows the ribs round the rib cage from the spine forwards, in sectors of a few degrees.
std::vector<RibTrack> track_ribs(const WorkingImage& image, const Mask& bone, const Cage& cage);
/// Sorts the ribs of each side from top to bottom and sets their numbers. Reports doubts in `warnings`.
void number_ribs(
    std::vector<RibTrack>& ribs, const Cage& cage, const mesh::ImageGrid& grid, std::vector<std::string>& warnings);

/// Grows the seeds over the bone, brightest voxels first, so that neighbours meet in the dark joints between bones.
/// @param labels in: seeds; out: the label of every reached voxel of `bone`
/// @param may_enter (label, voxel) -> true when the label may grow into the voxel
void grow_seeds(const WorkingImage& image, const Mask& bone, const std::vector<std::int16_t>& smooth_hu,
    std::vector<Label>& labels, const std::function<bool(Label, Voxel)>& may_enter);

/// Fills a bone (closing of 2 mm, then the holes of its sections), adds a thin tube along `line`, and keeps the largest
/// piece. Voxels of other bones keep their labels, except that the tube takes voxels with a label in `yielding`.
void make_solid(const mesh::ImageGrid& grid, std::vector<Label>& labels, Label label,
    const std::vector<Vec3>& line = {}, const std::vector<Label>& yielding = {});
/// Keeps the largest piece of each label in `which`; the other pieces get the label `rest`.
void keep_largest_pieces(
    const mesh::ImageGrid& grid, std::vector<Label>& labels, const std::vector<Label>& which, Label rest);

/// Clears voxels of the labels in `giving_way` that touch another bone for which must_part(own label, other label) is
/// true. Voxels touch over faces, and with `corners` also over edges and corners.
void part_bones(const mesh::ImageGrid& grid, std::vector<Label>& labels, const std::vector<Label>& giving_way,
    bool corners, const std::function<bool(Label, Label)>& must_part);

/// Label ids of the shoulder girdle.
struct GirdleIds {
    std::array<Label, 2> scapula {}, clavicle {}; ///< left, right
    Label other = 0; ///< id of bone that has no other name yet
};
/// Labels the core of a clavicle, from voxels without a label or with the label `other`. Returns points of the
/// clavicle's middle line (mm), or none when the image shows no clavicle.
/// @param not_rib bone that is no rib; the clavicle ends where the section of this bone widens
std::vector<Vec3> seed_clavicle(const mesh::ImageGrid& grid, const Mask& bone, const Cage& cage, bool left, Label other,
    Label clavicle, const Mask& not_rib, std::vector<Label>& labels);
/// Labels the remaining bone: shoulder blades, clavicles, other bone.
void label_girdle(const WorkingImage& image, const Mask& bone, const Cage& cage, const GirdleIds& ids, Label cartilage,
    std::vector<Label>& labels);

/// The cartilage of one rib. The line is empty when the rib's end, or the path from the end, was not found.
struct CartilagePath {
    bool left = true;
    int number = 0;
    std::vector<Vec3> line = {};
    double seen = 0.0; ///< share of the path on which the image shows cartilage
};
/// Labels the costal cartilages of ribs 1 to 10. Only voxels without a label are used, so the other bones come first.
std::vector<CartilagePath> add_cartilages(const WorkingImage& image, const CoarseImage& coarse, const Cage& cage,
    const Mask& bone, const std::vector<std::int16_t>& smooth_hu, const std::vector<RibTrack>& ribs, Label sternum,
    Label cartilage, std::vector<Label>& labels);

} // namespace retractor::datasets::segmentation
