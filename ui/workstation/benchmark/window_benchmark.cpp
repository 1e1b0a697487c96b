#include "ui/workstation/benchmark/window_benchmark.h"

#include "mesh/base/error.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/view/picture_view.h"
#include "ui/workstation/view/step_bar.h"

#include <QCoreApplication>
#include <QEventLoop>
#include <QImage>
#include <QMouseEvent>
#include <QTimer>
#include <QWheelEvent>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <deque>
#include <functional>
#include <mutex>
#include <numbers>
#include <set>
#include <thread>
#include <utility>

namespace retractor::ui {

namespace {

    using Clock = std::chrono::steady_clock;
    using namespace std::chrono_literals;

    constexpr auto kHandInterval = 16ms; ///< a mouse reports about 60 times a second
    constexpr auto kNotchInterval = 100ms;
    constexpr auto kRest = 2s; ///< long enough for the picture at rest to begin
    constexpr auto kLongestRest = 120s;
    constexpr auto kLongestPlan = 3600s;
    constexpr int kPollMs = 5;
    constexpr int kNotch = 120; ///< Qt's angle of one notch of a mouse wheel
    constexpr int kNotchesToAndFro = 5;

    double ms_between(Clock::time_point from, Clock::time_point to)
    {
        return std::chrono::duration<double, std::milli>(to - from).count();
    }

    /// Runs the event loop until something holds. @throws InputError naming it when it does not hold in time
    void run_until(const std::function<bool()>& holds, const char* what, std::chrono::seconds limit)
    {
        QTimer wake; // without it, a loop without events would not look again
        wake.start(kPollMs);
        for (const Clock::time_point begin = Clock::now(); !holds();) {
            QCoreApplication::processEvents(QEventLoop::WaitForMoreEvents);
            if (Clock::now() - begin > limit)
                throw InputError(std::string("waited in vain until ") + what);
        }
    }

    /// Notes when events were sent and handled, and when pictures reached the screen.
    class Notes : public QObject {
    public:
        explicit Notes(PictureView& view)
            : view_(view)
        {
            view_.installEventFilter(this);
            connect(&view_, &QOpenGLWidget::frameSwapped, this, [this] {
                if (std::exchange(drawn_, view_.pictures()) != view_.pictures())
                    pictures_.push_back(Clock::now());
            });
        }

        /// Called on the sending thread.
        /// @param of_motion whether the event moves the picture, and is not one of the hand at rest
        void send(QEvent* event, bool of_motion = true)
        {
            {
                const std::lock_guard lock(mutex_);
                sent_.push_back({ Clock::now(), of_motion });
            }
            QCoreApplication::postEvent(&view_, event);
        }

        /// In the order of handling.
        const std::vector<double>& delays_in_motion_ms() const { return in_motion_ms_; }
        double largest_delay_at_rest_ms() const { return at_rest_ms_; }
        const std::vector<Clock::time_point>& pictures() const { return pictures_; }
        bool all_handled()
        {
            const std::lock_guard lock(mutex_);
            return sent_.empty();
        }

    protected:
        bool eventFilter(QObject*, QEvent* event) override
        {
            const bool of_hand = event->type() == QEvent::MouseMove || event->type() == QEvent::MouseButtonPress
                || event->type() == QEvent::MouseButtonRelease || event->type() == QEvent::Wheel;
            const std::lock_guard lock(mutex_);
            if (of_hand && !sent_.empty()) {
                const double delay = ms_between(sent_.front().at, Clock::now());
                if (sent_.front().of_motion)
                    in_motion_ms_.push_back(delay);
                else
                    at_rest_ms_ = std::max(at_rest_ms_, delay);
                sent_.pop_front();
            }
            return false;
        }

    private:
        PictureView& view_;
        int drawn_ = view_.pictures(); ///< pictures when the last one reached the screen
        std::vector<Clock::time_point> pictures_;
        std::vector<double> in_motion_ms_;
        double at_rest_ms_ = 0.0;
        std::mutex mutex_;
        struct Sent {
            Clock::time_point at;
            bool of_motion = true;
        };
        std::deque<Sent> sent_;
    };

    QEvent* mouse_event(QEvent::Type type, const QPointF& at, Qt::MouseButton button, Qt::MouseButtons held)
    {
        return new QMouseEvent(type, at, at, at, button, held, Qt::NoModifier);
    }

    /// A place in the view and how far the hand goes from it, pixels.
    struct Place {
        QPointF middle;
        double radius = 0.0;
    };

    /// The middle of the view, or of the first slice.
    Place place_of(const PictureView& view)
    {
        const bool one = view.scenes().size() == 1;
        const double share = one ? 0.5 : 0.25;
        return { { share * view.width(), share * view.height() }, 0.4 * share * view.height() };
    }

    /// A circle, once in two seconds.
    QPointF hand_at(const Place& place, double seconds)
    {
        const double angle = std::numbers::pi * seconds;
        return place.middle + place.radius * QPointF(std::cos(angle), std::sin(angle));
    }

    using Send = std::function<void(Notes&, const Place&, double seconds, int number)>;

    void send_drag(Notes& notes, const Place& place, double seconds, int number)
    {
        const QPointF at = hand_at(place, seconds);
        notes.send(number == 0 ? mouse_event(QEvent::MouseButtonPress, at, Qt::LeftButton, Qt::LeftButton)
                               : mouse_event(QEvent::MouseMove, at, Qt::NoButton, Qt::LeftButton));
    }

    void send_notch(Notes& notes, const Place& place, double, int number)
    {
        const int notch = (number / kNotchesToAndFro) % 2 == 0 ? kNotch : -kNotch;
        notes.send(new QWheelEvent(
            place.middle, place.middle, {}, { 0, notch }, Qt::NoButton, Qt::NoModifier, Qt::NoScrollPhase, false));
    }

    /// Whether the window's own picture, under the full one, shows more than its background.
    bool shows_something(const QImage& picture)
    {
        constexpr std::size_t kColoursOfABackground = 100; // a gradient from top to bottom, and letters
        std::set<QRgb> colours;
        for (int y = 0; y < picture.height(); ++y)
            for (int x = 0; x < picture.width(); ++x)
                colours.insert(picture.pixel(x, y));
        return colours.size() > kColoursOfABackground;
    }

    /// Sends the motion and then, while the hand rests, moves without a button.
    MotionFigures measure(
        PictureView& view, const Send& send, Clock::duration interval, bool releases, Clock::duration motion)
    {
        Notes notes(view);
        const Place place = place_of(view);
        std::atomic<bool> moved = false, finished = false;
        MotionFigures figures;
        const Clock::time_point begin = Clock::now();
        Clock::time_point end = begin;
        const Clock::duration rest = std::min<Clock::duration>(kRest, motion);
        std::jthread hand([&] {
            for (Clock::time_point at = begin; at - begin < motion; at += interval) {
                std::this_thread::sleep_until(at);
                send(notes, place, 1e-3 * ms_between(begin, at), figures.events++);
            }
            end = Clock::now();
            moved = true;
            if (releases)
                notes.send(mouse_event(
                    QEvent::MouseButtonRelease, hand_at(place, 1e-3 * ms_between(begin, end)), Qt::LeftButton, {}));
            for (Clock::time_point at = end; at - end < rest; at += kHandInterval) {
                std::this_thread::sleep_until(at);
                notes.send(mouse_event(QEvent::MouseMove, hand_at(place, 0.0), Qt::NoButton, {}), false);
            }
            finished = true;
        });
        run_until(
            [&] {
                if (moved && figures.full_ms == 0.0 && !view.coarse())
                    figures.full_ms = ms_between(end, Clock::now());
                return finished && notes.all_handled() && figures.full_ms > 0.0;
            },
            "the full picture was drawn", kLongestRest);
        hand.join();

        figures.seconds = 1e-3 * ms_between(begin, end);
        for (const Clock::time_point picture : notes.pictures())
            figures.pictures += picture <= end ? 1 : 0;
        if (notes.pictures().empty() || !shows_something(view.grabFramebuffer()))
            throw InputError("the motion changed nothing in the picture");
        figures.pictures_per_s = figures.pictures / figures.seconds;
        figures.rest_delay_largest_ms = notes.largest_delay_at_rest_ms();
        std::vector<double> delays = notes.delays_in_motion_ms();
        std::sort(delays.begin(), delays.end());
        figures.delay_median_ms = delays.at(delays.size() / 2);
        figures.delay_p99_ms = delays.at(std::min(delays.size() - 1, delays.size() * 99 / 100));
        figures.delay_largest_ms = delays.back();
        return figures;
    }

    void append(std::vector<MotionFigures>& all, std::vector<MotionFigures> more)
    {
        all.insert(all.end(), more.begin(), more.end());
    }

    /// Drags with the left button, 60 events a second, which turns a picture in space and moves the point in which
    /// slices meet; then turns the wheel to and fro, 10 notches a second, which zooms or steps through slices.
    std::vector<MotionFigures> measure_motions(PictureView& view, const std::string& picture, Clock::duration motion)
    {
        std::vector<MotionFigures> figures = { measure(view, send_drag, kHandInterval, true, motion),
            measure(view, send_notch, kNotchInterval, false, motion) };
        figures[0].motion = "drag";
        figures[1].motion = "wheel";
        for (MotionFigures& f : figures)
            f.picture = picture;
        return figures;
    }

    void settle(const MainWindow& window, PictureView& view)
    {
        run_until([&] { return window.idle() && view.ready(); }, "the window was idle", kLongestPlan);
    }

} // namespace

std::vector<MotionFigures> measure_window(MainWindow& window, bool plan, double seconds)
{
    const auto motion = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
    PictureView& view = window.view();
    settle(window, view);
    if (!view.is_drawn())
        throw InputError("the window shows no picture to measure: " + window.error_line());
    std::vector<MotionFigures> figures;
    const auto measure_view = [&](const std::string& field, const std::string& name) {
        const ViewPreset preset = *view_from_string(name);
        if (!window.model()->view_available(preset))
            return;
        window.set_view(preset);
        settle(window, view);
        append(figures, measure_motions(view, field + ", " + name, motion));
    };
    for (const char* name : { "surgeon", "overview", "slices" })
        measure_view("closed", name);
    if (!plan)
        return figures;
    window.plan_selected();
    settle(window, view);
    if (window.model()->state(*window.model()->selected()).field == nullptr)
        throw InputError("there is no opened field to measure: " + window.error_line());
    for (const char* name : { "surgeon", "overview" })
        measure_view("opened", name);
    window.set_conference(true);
    StepBar& steps = window.conference_bar();
    steps.on_step(1 - static_cast<int>(steps.number())); // from the first step on
    for (const std::size_t count = steps.count();; steps.on_step(1)) {
        settle(window, view);
        if (window.model()->show_opened() || window.model()->wall_look() == WallLook::see_through)
            append(figures, measure_motions(view, "conference, " + steps.title().toStdString(), motion));
        if (steps.number() == count)
            break;
    }
    window.set_conference(false);
    return figures;
}

std::string to_json(const std::vector<MotionFigures>& figures, MainWindow& window)
{
    nlohmann::json motions = nlohmann::json::array();
    for (const MotionFigures& f : figures)
        motions.push_back({ { "picture", f.picture }, { "motion", f.motion }, { "events", f.events },
            { "seconds", f.seconds }, { "pictures", f.pictures }, { "pictures_per_s", f.pictures_per_s },
            { "delay_median_ms", f.delay_median_ms }, { "delay_p99_ms", f.delay_p99_ms },
            { "delay_largest_ms", f.delay_largest_ms }, { "rest_delay_largest_ms", f.rest_delay_largest_ms },
            { "full_ms", f.full_ms } });
    const nlohmann::json document { { "view_width", window.view().width() }, { "view_height", window.view().height() },
        { "motions", motions } };
    return document.dump(2) + "\n";
}

} // namespace retractor::ui
