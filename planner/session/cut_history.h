#pragma once
// The cuts of a surgery session that can be undone or redone, with what a surgeon reads about each. Units mm.

#include "mesh/cutting/cut_session.h"
#include "mesh/cutting/store/blade.h"
#include "mesh/image/volume.h"
#include "planner/case/division.h"

#include <cstddef>
#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace retractor::planner {

/// A finished cut or removed tissue, active or undone.
struct CutEntry {
    int number = 0; ///< counted from 1 in the order of cutting
    std::string taken_out {}; ///< name of the removed tissue, of the largest part when several; empty: a cut
    bool several_tissues = false; ///< several tissues were removed
    double length_mm = 0.0, depth_mm = 0.0;
    mesh::CutReport report {};
    bool in_force = true;
    /// Reason why a part of the line was not cut, or a part of the ball not removed; empty: nothing is missing.
    std::string omitted {};
    bool as_planned = false; ///< the planned incision, which no hand drew
    std::optional<StrokeWay> divides {}; ///< a stroke beyond the skin; nothing: a cut from the skin, or not known
    mesh::Blade blade {}; ///< of a cut from the skin; without points where it is restored, and for all else
    /// Read from disk, which does not keep lengths and reports: the report has only lip_area_mm2 and
    /// removed_volume_mm3.
    bool restored = false;
};

/// The present lips of a cut.
struct LipsOfCut {
    double area_mm2 = 0.0; ///< area of one lip at rest
    bool bared = false; ///< an ablation exposed a part of the faces
};

/// The lips of the first `cuts` cuts, in order.
std::vector<LipsOfCut> lips_of_cuts(const mesh::CutSession& session, std::size_t cuts);

/// Name of a label; "nothing" when the table does not have the label.
std::string label_name(const mesh::LabelTable& table, Label label);

/// The entry of a cut that was read from disk. CutHistory sets its number.
/// @param rest the session's vertices at rest, which `take` brings up to date
/// @param take applies the delta; volumes before and after are needed
CutEntry restored_entry(const mesh::MeshDelta& delta, const LipsOfCut& lips, const mesh::LabelTable& labels,
    const Points& rest, const std::function<void()>& take);

class CutHistory {
public:
    const std::vector<CutEntry>& entries() const { return entries_; }
    /// Adds a new cut, which takes the place of all undone cuts.
    void add(CutEntry entry);
    /// Adds a restored cut behind all others.
    void append(CutEntry entry);
    /// @pre index < entries().size()
    void set_in_force(std::size_t index, bool in_force);

private:
    std::vector<CutEntry> entries_;
};

} // namespace retractor::planner
