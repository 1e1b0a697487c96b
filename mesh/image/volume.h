#pragma once
// Voxel images: the CT in Hounsfield units and the labels, each on its own grid. Units mm; frame patient LPS.

#include "mesh/base/geometry.h"

#include <Eigen/Geometry>

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace retractor::mesh {

/// A regular grid. The centre of voxel (i, j, k) is origin + direction * (spacing .* (i, j, k)). In memory i runs
/// fastest. The columns of `direction` are the unit axes of i, j and k; they are orthonormal and may be left-handed.
struct ImageGrid {
    std::array<int, 3> size { 0, 0, 0 };
    Vec3 spacing = Vec3::Ones(); ///< mm
    Vec3 origin = Vec3::Zero(); ///< mm, patient LPS, centre of voxel (0, 0, 0)
    Mat3 direction = Mat3::Identity();

    std::size_t voxel_count() const
    {
        return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1])
            * static_cast<std::size_t>(size[2]);
    }
    std::size_t offset(int i, int j, int k) const
    {
        return (static_cast<std::size_t>(k) * static_cast<std::size_t>(size[1]) + static_cast<std::size_t>(j))
            * static_cast<std::size_t>(size[0])
            + static_cast<std::size_t>(i);
    }
    bool contains(int i, int j, int k) const
    {
        return i >= 0 && j >= 0 && k >= 0 && i < size[0] && j < size[1] && k < size[2];
    }
    /// World position (mm) of a continuous index.
    Vec3 world(const Vec3& index) const { return origin + direction * spacing.cwiseProduct(index); }
    /// Continuous index of a world position (mm).
    Vec3 index(const Vec3& world) const { return (direction.transpose() * (world - origin)).cwiseQuotient(spacing); }
    double voxel_volume() const { return spacing.prod(); }
};

/// Checks a grid.
/// @throws InputError unless sizes are positive, spacing is positive and finite, and direction is orthonormal to 1e-4
/// (DICOM stores direction cosines as decimal strings)
void check_grid(const ImageGrid& grid);

/// CT values, Hounsfield units rounded to integers.
struct Volume {
    ImageGrid grid;
    std::vector<std::int16_t> voxels;
};

/// Use of a structure by the planner; independent of its material.
enum class Role {
    wall, ///< becomes tetrahedra: it is cut and moved
    voxel, ///< stays as voxels; blocks the view unless an approach holds the organ aside
    target, ///< what the surgeon wants to see; stays as voxels
    at_risk, ///< stays as voxels, and distances to it are reported
};

std::string_view to_string(Role role);
std::optional<Role> role_from_string(std::string_view text);

struct LabelInfo {
    Label id = 0;
    std::string name; ///< e.g. "sternum", "rib_left_5"
    std::string material; ///< key into the material table, e.g. "bone"
    Role role = Role::voxel;
};

using LabelTable = std::vector<LabelInfo>;

/// The entry with this name or id, or nullptr.
const LabelInfo* find_label(const LabelTable& table, std::string_view name);
const LabelInfo* find_label(const LabelTable& table, Label id);
/// The entry with this name. @throws InputError naming a label that is not in the table
const LabelInfo& label_named(const LabelTable& table, std::string_view name);
/// The ids of these names. @throws InputError as label_named() does
std::vector<Label> label_ids(const LabelTable& table, std::span<const std::string> names);

/// One flag per possible label id, 0 or 1.
using LabelFlags = std::vector<std::uint8_t>;
inline constexpr std::size_t kLabelCount = std::size_t { std::numeric_limits<Label>::max() } + 1;

/// Flags the entries of a table for which a condition holds. Label 0 is never flagged.
template <class Condition> LabelFlags flagged_labels(const LabelTable& table, Condition&& holds)
{
    LabelFlags flags(kLabelCount, 0);
    for (const LabelInfo& info : table)
        flags[info.id] = info.id != 0 && holds(info) ? 1 : 0;
    return flags;
}
LabelFlags flagged_labels(std::span<const Label> labels);
inline bool is_wall(const LabelInfo& info) { return info.role == Role::wall; }

/// Labels with their table. Every voxel value is 0 or an id of the table.
struct LabelVolume {
    ImageGrid grid;
    std::vector<Label> voxels;
    LabelTable table;
};

/// Calls visit(i, j, k, label) for every voxel, in the order of the voxels.
template <class Visit> void visit_voxels(const LabelVolume& labels, Visit&& visit)
{
    std::size_t at = 0;
    for (int k = 0; k < labels.grid.size[2]; ++k)
        for (int j = 0; j < labels.grid.size[1]; ++j)
            for (int i = 0; i < labels.grid.size[0]; ++i)
                visit(i, j, k, labels.voxels[at++]);
}

/// The label at the voxel nearest to a world position (mm, LPS); 0 outside the grid.
Label label_at(const LabelVolume& labels, const Vec3& world);

} // namespace retractor::mesh
