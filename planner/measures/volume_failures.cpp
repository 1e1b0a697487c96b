#include "planner/measures/volume_failures.h"

#include "mesh/base/assert.h"
#include "mesh/base/text_format.h"
#include "mesh/image/skeleton.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <map>
#include <utility>

namespace retractor::planner {

namespace {

    Vec3 corner(const mesh::TetMesh& wall, VertexId v) { return wall.vertices.row(v).transpose(); }

    double rest_volume(const mesh::TetMesh& wall, TetId t)
    {
        const auto nodes = wall.tet(t);
        const Vec3 origin = corner(wall, nodes[0]);
        Mat3 edges;
        for (int axis = 0; axis < 3; ++axis)
            edges.col(axis) = corner(wall, nodes[static_cast<std::size_t>(axis) + 1]) - origin;
        return std::abs(edges.determinant()) / 6.0;
    }

    Vec3 middle(const mesh::TetMesh& wall, TetId t)
    {
        Vec3 sum = Vec3::Zero();
        for (const VertexId v : wall.tet(t).first(4))
            sum += corner(wall, v);
        return 0.25 * sum;
    }

    /// How far a volume ratio is from 1; the same for half and for twice the volume.
    double change(double ratio)
    {
        return ratio > 0.0 ? std::abs(std::log(ratio)) : std::numeric_limits<double>::infinity();
    }

    bool is_soft(const mesh::LabelTable& table, Label label)
    {
        const mesh::LabelInfo* info = mesh::find_label(table, label);
        return info == nullptr || !mesh::is_skeleton(*info);
    }

} // namespace

VolumeFailures find_volume_failures(const mesh::TetMesh& wall, std::span<const double> volume_ratio,
    const mesh::LabelTable& table, int inverted_elements)
{
    RETRACTOR_ASSERT(volume_ratio.size() == wall.tet_count());
    VolumeFailures failures;
    double soft = 0.0, failed = 0.0, largest_change = 0.0;
    for (std::size_t t = 0; t < wall.tet_count(); ++t) {
        if (!is_soft(table, wall.labels[t]))
            continue;
        const double ratio = volume_ratio[t], volume = rest_volume(wall, static_cast<TetId>(t));
        soft += volume;
        failures.smallest_ratio = std::min(failures.smallest_ratio, ratio);
        failures.largest_ratio = std::max(failures.largest_ratio, ratio);
        if (ratio >= kLeastVolumeRatio && ratio <= kMostVolumeRatio)
            continue;
        failed += volume;
        ++failures.elements;
        if (change(ratio) > largest_change) {
            largest_change = change(ratio);
            failures.at = middle(wall, static_cast<TetId>(t));
        }
    }
    failures.share = soft > 0.0 ? failed / soft : 0.0;
    failures.believable = failures.share <= kMostFailedShare && inverted_elements == 0;
    return failures;
}

std::vector<double> averaged_volume_ratios(const mesh::TetMesh& wall, std::span<const double> volume_ratio)
{
    RETRACTOR_ASSERT(volume_ratio.size() == wall.tet_count());
    struct Sum {
        double rest = 0.0, deformed = 0.0;
    };
    std::map<std::pair<VertexId, Label>, Sum> sums;
    for (std::size_t t = 0; t < wall.tet_count(); ++t) {
        const double volume = rest_volume(wall, static_cast<TetId>(t));
        for (const VertexId v : wall.tet(static_cast<TetId>(t)).first(4)) {
            Sum& sum = sums[{ v, wall.labels[t] }];
            sum.rest += volume;
            sum.deformed += volume * volume_ratio[t];
        }
    }
    std::vector<double> averaged(wall.tet_count(), 0.0);
    for (std::size_t t = 0; t < wall.tet_count(); ++t)
        for (const VertexId v : wall.tet(static_cast<TetId>(t)).first(4)) {
            const Sum& sum = sums[{ v, wall.labels[t] }];
            averaged[t] += 0.25 * sum.deformed / sum.rest;
        }
    return averaged;
}

bool keeps_volume(const FieldMetrics& field) { return !field.volume_failures || field.volume_failures->believable; }

bool is_believable(const FieldMetrics& field) { return keeps_volume(field) && field.region.piercing.empty(); }

std::string volume_failure_text(const FieldMetrics& field)
{
    if (!field.volume_failures || (keeps_volume(field) && field.volume_failures->elements == 0))
        return {};
    const VolumeFailures& failures = *field.volume_failures;
    std::string text = keeps_volume(field) ? "caution: " : "not usable: these numbers are not to be believed: ";
    if (failures.elements > 0)
        text += formatted("%.2g %% of the soft tissue changes its volume by more than a tenth, to between %.2f and "
                          "%.2f of its volume at rest, most of all ",
                    100.0 * failures.share, failures.smallest_ratio, failures.largest_ratio)
            + (failures.place.empty() ? "at " + in_words(failures.at) : failures.place);
    if (field.inverted_elements > 0)
        text += std::string(failures.elements > 0 ? "; " : "")
            + formatted("%d element(s) are inside out", field.inverted_elements);
    return text
        + (keeps_volume(field) ? "; strain is wrong there" : "; open less, hold more hooks, or use a finer mesh");
}

} // namespace retractor::planner
