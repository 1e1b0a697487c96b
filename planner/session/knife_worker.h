#pragma once
// The cutting desk on a thread of its own: orders go in, the newest state comes out. The window never waits for it.

#include "mesh/base/serial_executor.h"
#include "planner/session/cutting_desk.h"
#include "planner/session/kept_cuts.h"

#include <chrono>
#include <cstddef>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

namespace retractor {

/// Everything a window shows, as of one moment.
struct KnifeNews {
    enum class Phase {
        preparing,
        asking, ///< cuts of the last time are on disk: restore them, or set them aside?
        ready,
        failed,
    };
    Phase phase = Phase::preparing;
    std::string stage; ///< preparing: what is being done, and how far
    double fraction = 0.0;
    std::string failure; ///< failed: why
    std::size_t kept_cuts = 0; ///< asking: how many

    LabelTable labels; ///< ready; and the next two
    std::shared_ptr<const BeyondSurface> beyond; ///< null: nothing
    std::shared_ptr<const std::vector<EdgePlace>> outline; ///< of where can be cut; see region_outline()
    std::shared_ptr<const WallPicture> picture;
    std::vector<CutEntry> cuts;
    bool can_undo = false, can_redo = false, stroke_open = false;
    std::size_t refused_stroke = 0; ///< the last stroke, when it could not be begun, by its number; 0: it was begun
    std::string answer; ///< the last thing the surgeon should know
    bool refused = false; ///< the answer is why something was not done
    std::size_t answers = 0; ///< how many answers there were: tells a new one from the last
    double tension = 0.0; ///< strain
    double case_tension = 0.0; ///< the largest that the case states; 0: none
    double gape_mm = 0.0; ///< of the widest wound
    bool moving = false; ///< the wound is still opening
    double step_ms = 0.0; ///< of the last step of the knife
    double picture_ms = 0.0; ///< making the surface after it
    double relax_ms = 0.0; ///< of the last frame of the wound's opening
    HookReport hooks;
    std::size_t planned_hooks = 0; ///< how many the approach has
};

class KnifeWorker {
public:
    /// @param prepare runs on the worker's thread; what it throws is the failure.
    /// @param on_news called on the worker's thread when there is something new, once until news() is asked for.
    KnifeWorker(std::function<OperatingTable(const Job&)> prepare, std::function<void()> on_news);
    /// Stops preparing and leaves kept cuts as they are; finishes a stroke that is open, so that what was cut is kept.
    ~KnifeWorker();
    KnifeWorker(const KnifeWorker&) = delete;
    KnifeWorker& operator=(const KnifeWorker&) = delete;

    /// Answers the question; does nothing when none was asked.
    void restore(bool wanted);
    /// @returns the stroke's number, from 1. A former one whose end was refused is finished first.
    std::size_t begin_stroke(const Touch& at, const KnifeSettings& settings);
    /// Of the last stroke begun; they do nothing when it was refused.
    void draw_to(const Touch& at);
    void leave_wall(); ///< the knife is drawn where there is none
    void finish_stroke();
    /// Whichever is open.
    void abandon_stroke();
    /// See CuttingDesk::take_out.
    void take_out(const Touch& at, double radius_mm);
    /// Do nothing when there is nothing to take back or make again.
    void undo();
    void redo();
    /// Undoes or redoes until this many cuts are in force, or as near to it as can be.
    void go_to(std::size_t cuts);
    void set_tension(double strain);
    void place_hook(const Touch& at);
    void take_planned_hooks();
    /// Of orders that were not carried out yet only the newest of each hook counts: the wound follows the hand.
    void pull_hook(HookId hook, const Vec3& asked);
    void pull_all_hooks(double mm);
    void pull_hooks_by_share(double share);
    void set_yield(double force_N);
    void set_nonlinear(bool wanted);
    void take_off_hook(HookId hook);
    void take_off_hooks();
    /// Writes the cut wall at rest as VTU and says so.
    void export_wall(const std::filesystem::path& path);

    KnifeNews news();
    /// Nothing is being prepared, no order waits or is being carried out, and the wound is at rest.
    bool idle() const;

private:
    using Order = std::function<KnifeAnswer(CuttingDesk&)>;
    void post(Order order);
    void post_latest(const std::string& key, Order order);
    void ask_to_restore(OperatingTable table, KeptCuts kept);
    void prepare_desk(const std::function<OperatingTable(const Job&)>& prepare, const Job& job);
    std::unique_ptr<CuttingDesk> lay_desk(
        OperatingTable table, std::optional<KeptCuts> kept, std::optional<bool> wanted, const Job& job);
    void make_ready(const std::function<std::unique_ptr<CuttingDesk>()>& lay);
    void say(std::string answer, bool refused);
    void say_too(const std::string& more); ///< after what was said last
    static KnifeAnswer finish(CuttingDesk& desk);
    void say_remark(CuttingDesk& desk);
    std::optional<std::chrono::steady_clock::time_point> step();
    void carry_out(const Order& order);
    void tell(CuttingDesk& desk);
    void open_wound(CuttingDesk& desk);
    void announce();

    std::function<void()> on_news_;
    std::size_t strokes_ = 0; ///< begun by the window; its thread only
    mutable std::mutex mutex_; ///< of the next three
    KnifeNews news_;
    bool announced_ = false;
    std::vector<Order> deferred_; ///< that came while the question was open

    // The executor's thread only:
    struct Question {
        OperatingTable table;
        KeptCuts kept;
    };
    std::optional<Question> question_; ///< none: it was not asked, or is answered
    std::string caution_; ///< of the table
    std::unique_ptr<CuttingDesk> desk_; ///< null: being prepared, or failed
    std::size_t refused_stroke_ = 0; ///< see KnifeNews
    bool changed_ = false; ///< an order was carried out that the news does not tell of

    SerialExecutor executor_; ///< last: its tasks use all of the above
};

} // namespace retractor
