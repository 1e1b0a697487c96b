#include "planner/approach/divided_bones.h"

#include <algorithm>
#include <cmath>
#include <map>

namespace retractor::planner {

std::vector<std::string> divided_bones(const mesh::LabelVolume& labels, const Approach& approach, double least_mm2)
{
    constexpr double kStepMm = 1.0;
    std::map<Label, double> severed_mm2;
    for (std::size_t n = 0; n + 1 < approach.incision.size(); ++n) {
        const double length = (approach.incision[n + 1] - approach.incision[n]).norm();
        const int along = std::max(1, static_cast<int>(std::ceil(length / kStepMm)));
        const int down = std::max(1, static_cast<int>(std::ceil(approach.depth_mm / kStepMm)));
        for (int i = 0; i < along; ++i) {
            const IncisionPlace place { n, (i + 0.5) / along };
            const Vec3 skin = place.of(approach.incision), direction = place.of(approach.directions).normalized();
            for (int j = 0; j < down; ++j)
                severed_mm2[mesh::label_at(labels, skin + (j + 0.5) / down * approach.depth_mm * direction)]
                    += length / along * approach.depth_mm / down;
        }
    }
    std::vector<std::string> names;
    for (const mesh::LabelInfo& info : labels.table) {
        const auto severed = severed_mm2.find(info.id);
        const bool kept = std::ranges::find(approach.uncut_labels, info.name) != approach.uncut_labels.end();
        if (info.material == "bone" && mesh::is_wall(info) && !kept && severed != severed_mm2.end()
            && severed->second >= least_mm2)
            names.push_back(info.name);
    }
    return names;
}

} // namespace retractor::planner
