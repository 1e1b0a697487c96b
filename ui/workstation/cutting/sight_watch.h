#pragma once
// Measures what is seen through the wound that is being opened by hand, on a thread of its own. While a measurement
// runs, a newer wound replaces the one that waits, so that the numbers are never further behind than one measurement.

#include "mesh/base/serial_executor.h"
#include "planner/measures/sight/live_view.h"
#include "planner/session/wall_picture.h"

#include <QElapsedTimer>
#include <QObject>

#include <functional>
#include <memory>
#include <optional>
#include <string>

namespace retractor::ui {

class SightWatch : public QObject {
public:
    using Look = std::function<planner::SeenNow(const TriMesh& wall, const TriMesh& around, const Job&)>;

    SightWatch();

    /// Measures this wound, unless it is measured already.
    /// @param around what else hides something, as shown: the wall outside the model, hooks and blades
    void watch(std::shared_ptr<const planner::WallPicture> wall, TriMesh around, const Look& look);
    /// Whether watch() was called with this wound last.
    bool watches(const std::shared_ptr<const planner::WallPicture>& wall) const { return wall == newest_; }
    /// Shows nothing until the next watch().
    void forget();
    bool idle() const { return !running_; }

    /// What the surgeon reads: the last measurement, its error and its age, or why there is none; empty: nothing is
    /// known yet.
    QString text() const;
    /// Called when text() has changed, but not while it only ages.
    std::function<void()> on_change;

private:
    struct Wound {
        std::shared_ptr<const planner::WallPicture> wall;
        TriMesh around;
        Look look;
    };
    void begin(Wound wound);

    std::shared_ptr<const planner::WallPicture> newest_, measured_;
    std::optional<Wound> waiting_;
    std::optional<planner::SeenNow> seen_;
    std::string failure_;
    QElapsedTimer since_, begun_; ///< since the measured wound was the newest; since the running measurement began
    bool running_ = false;
    int number_ = 0; ///< of what is watched; a measurement for an older one is dropped
    SerialExecutor executor_; ///< declared last: its tasks use the other members
};

} // namespace retractor::ui
