#include "ui/workstation/cutting/sight_watch.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"
#include "ui/workstation/view/background_picture.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace retractor::ui {

namespace {

    /// The wall as shown, without vertices that no triangle uses: these are nowhere.
    TriMesh shown_mesh(const planner::WallPicture& wall)
    {
        TriMesh mesh { .vertices = {}, .triangles = wall.surface->triangles, .labels = wall.surface->labels };
        std::vector<VertexId> new_id(static_cast<std::size_t>(wall.shown.rows()), -1);
        std::vector<VertexId> used;
        for (auto& triangle : mesh.triangles)
            for (VertexId& v : triangle) {
                VertexId& id = new_id[static_cast<std::size_t>(v)];
                if (id < 0) {
                    id = static_cast<VertexId>(used.size());
                    used.push_back(v);
                }
                v = id;
            }
        mesh.vertices.resize(static_cast<Eigen::Index>(used.size()), 3);
        for (std::size_t n = 0; n < used.size(); ++n)
            mesh.vertices.row(static_cast<Eigen::Index>(n)) = wall.shown.row(used[n]);
        return mesh;
    }

} // namespace

SightWatch::SightWatch()
{
    executor_.post([](const Job&) { lower_priority(); });
}

void SightWatch::watch(std::shared_ptr<const planner::WallPicture> wall, TriMesh around, const Look& look)
{
    if (wall == newest_ || wall == nullptr || !look)
        return;
    if (newest_ == measured_ && measured_ != nullptr)
        since_.start();
    newest_ = wall;
    Wound wound { .wall = std::move(wall), .around = std::move(around), .look = look };
    if (running_)
        waiting_ = std::move(wound);
    else
        begin(std::move(wound));
}

void SightWatch::begin(Wound wound)
{
    running_ = true;
    begun_.start();
    executor_.post([this, number = number_, wound = std::move(wound)](const Job& job) {
        auto seen = std::make_shared<std::optional<planner::SeenNow>>();
        std::string failure;
        try {
            *seen = wound.look(shown_mesh(*wound.wall), wound.around, job);
        } catch (...) {
            failure = to_string(current_failure());
        }
        QMetaObject::invokeMethod(
            this,
            [this, number, seen, failure, wall = wound.wall] {
                running_ = false;
                if (number == number_ && (!*seen || (*seen)->status == planner::ExposureStatus::done)) {
                    seen_ = *seen;
                    failure_ = failure;
                    measured_ = wall;
                    since_ = begun_;
                    if (on_change)
                        on_change();
                }
                if (waiting_)
                    begin(*std::exchange(waiting_, std::nullopt));
            },
            Qt::QueuedConnection);
    });
}

void SightWatch::forget()
{
    ++number_;
    executor_.cancel();
    waiting_.reset();
    newest_.reset();
    measured_.reset();
    seen_.reset();
    failure_.clear();
}

QString SightWatch::text() const
{
    if (!failure_.empty())
        return QString::fromStdString("What is seen cannot be measured: " + failure_);
    if (!seen_)
        return newest_ != nullptr ? "Measuring what is seen of the target …" : QString();
    std::string text = formatted("The best eye sees %.0f %% of the target (\u00b1 %.0f)", 100.0 * seen_->seen_fraction,
        std::max(1.0, 100.0 * seen_->sampling_error));
    if (seen_->seen_fraction > 0.0)
        text += formatted(", %.0f\u00b0 off the straight view", seen_->off_straight_deg);
    if (newest_ != measured_)
        text += formatted("; %.1f s ago", 1e-3 * static_cast<double>(since_.elapsed()));
    return QString::fromStdString(text + ".");
}

} // namespace retractor::ui
