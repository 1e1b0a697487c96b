#include "mesh/image/volume.h"

#include "mesh/base/assert.h"
#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>

namespace retractor::mesh {

namespace {

    constexpr std::array<std::pair<Role, std::string_view>, 4> kRoleNames { {
        { Role::wall, "wall" },
        { Role::voxel, "voxel" },
        { Role::target, "target" },
        { Role::at_risk, "at-risk" },
    } };

    /// Direction cosines arrive as decimal strings with six or so digits.
    constexpr double kDirectionTolerance = 1e-4;

} // namespace

void check_grid(const ImageGrid& grid)
{
    for (const int n : grid.size)
        if (n <= 0)
            throw InputError("image size must be positive, got " + std::to_string(n));
    if (!grid.spacing.allFinite() || grid.spacing.minCoeff() <= 0.0)
        throw InputError("image spacing must be positive and finite");
    if (!grid.origin.allFinite() || !grid.direction.allFinite())
        throw InputError("image origin and direction must be finite");
    const Mat3 gram = grid.direction.transpose() * grid.direction;
    if ((gram - Mat3::Identity()).cwiseAbs().maxCoeff() > kDirectionTolerance)
        throw InputError("image axes are not orthonormal (sheared or singular direction matrix)");
}

std::string_view to_string(Role role)
{
    for (const auto& [value, name] : kRoleNames)
        if (value == role)
            return name;
    throw InputError("unknown role");
}

std::optional<Role> role_from_string(std::string_view text)
{
    for (const auto& [value, name] : kRoleNames)
        if (name == text)
            return value;
    return std::nullopt;
}

const LabelInfo* find_label(const LabelTable& table, std::string_view name)
{
    const auto it = std::find_if(table.begin(), table.end(), [&](const LabelInfo& l) { return l.name == name; });
    return it == table.end() ? nullptr : &*it;
}

const LabelInfo* find_label(const LabelTable& table, Label id)
{
    const auto it = std::find_if(table.begin(), table.end(), [&](const LabelInfo& l) { return l.id == id; });
    return it == table.end() ? nullptr : &*it;
}

const LabelInfo& label_named(const LabelTable& table, std::string_view name)
{
    const LabelInfo* info = find_label(table, name);
    if (info == nullptr)
        throw InputError("there is no label of this name", std::string(name));
    return *info;
}

std::vector<Label> label_ids(const LabelTable& table, std::span<const std::string> names)
{
    std::vector<Label> ids;
    for (const std::string& name : names)
        ids.push_back(label_named(table, name).id);
    return ids;
}

LabelFlags flagged_labels(std::span<const Label> labels)
{
    LabelFlags flags(kLabelCount, 0);
    for (const Label label : labels)
        flags[label] = 1;
    return flags;
}

Label label_at(const LabelVolume& labels, const Vec3& world)
{
    const Vec3 index = labels.grid.index(world);
    if (!index.allFinite() || index.cwiseAbs().maxCoeff() > 1e6)
        return 0;
    const int i = static_cast<int>(std::lround(index.x()));
    const int j = static_cast<int>(std::lround(index.y()));
    const int k = static_cast<int>(std::lround(index.z()));
    RETRACTOR_ASSERT(!labels.grid.contains(i, j, k) || labels.grid.offset(i, j, k) < labels.voxels.size());
    return labels.grid.contains(i, j, k) ? labels.voxels[labels.grid.offset(i, j, k)] : Label { 0 };
}

} // namespace retractor::mesh
