#include "haptics/device/hd_session.h"

#include "mesh/base/error.h"
#include "mesh/base/text_format.h"

#include <algorithm>
#include <array>
#include <clocale>
#include <cmath>
#include <thread>

namespace retractor::haptics {

namespace {

    constexpr int kQueueLimit = 64; ///< entries read in one go; an endless queue must not hold up the servo
    /// After this time without a call the scheduler counts as dead.
    constexpr std::chrono::milliseconds kSilentScheduler { 300 };
    constexpr double kOverrun = 50.0; ///< mm outside the workspace, farther than the device's arm reaches

    /// Sets the C locale for numbers, because the vendor's configuration files have decimal points.
    class PlainNumbers {
    public:
        PlainNumbers()
            : plain_(::newlocale(LC_NUMERIC_MASK, "C", static_cast<locale_t>(nullptr)))
            , old_(::uselocale(plain_))
        {
        }
        ~PlainNumbers()
        {
            ::uselocale(old_);
            ::freelocale(plain_);
        }
        PlainNumbers(const PlainNumbers&) = delete;
        PlainNumbers& operator=(const PlainNumbers&) = delete;

    private:
        locale_t plain_, old_;
    };

    const char* meaning(hd::ErrorCode code) noexcept
    {
        switch (code) {
        case hd::kWarmMotors:
            return "the motors are warm";
        case hd::kExceededForce:
            return "more than the largest force";
        case hd::kExceededImpulse:
            return "the force changed too fast";
        case hd::kExceededVelocity:
            return "moved too fast";
        case hd::kForceError:
            return "force error";
        case hd::kDeviceFault:
            return "device fault";
        case hd::kAlreadyInitiated:
            return "already in use";
        case hd::kCommError:
            return "communication error";
        case hd::kCommConfigError:
            return "communication is not configured";
        case hd::kTimerError:
            return "timer error";
        case hd::kIllegalBegin:
        case hd::kIllegalEnd:
        case hd::kFrameError:
            return "frames are not begun and ended in turn";
        case hd::kInvalidPriority:
        case hd::kSchedulerFull:
            return "the scheduler takes no more";
        case hd::kInvalidLicense:
            return "no licence";
        default:
            return code < 0x0200 ? "a call was wrong" : "unknown error";
        }
    }

    std::string hex(hd::ErrorCode code) { return formatted("0x%04x", code); }

    Workspace workspace_of(const std::array<double, 6>& box)
    {
        return { { box[0], box[1], box[2] }, { box[3], box[4], box[5] } };
    }

} // namespace

DeviceTrouble trouble_of(hd::ErrorCode code) noexcept
{
    switch (code & 0xFF00u) {
    case 0x0200u:
        return DeviceTrouble::over_limit;
    case 0x0300u:
        return code == hd::kAlreadyInitiated ? DeviceTrouble::none : DeviceTrouble::lost;
    default:
        return DeviceTrouble::none;
    }
}

std::string describe(const HdProblem& problem)
{
    std::string text = hex(problem.code) + ", " + meaning(problem.code);
    if (problem.trouble != DeviceTrouble::none)
        text += ": device " + std::to_string(problem.device) + " is " + std::string(to_string(problem.trouble));
    return text;
}

/// One device inside the session's callback.
class HdSession::Touch : public Device {
public:
    Touch(HdSession& session, hd::Handle device_handle)
        : handle(device_handle)
        , session_(session)
    {
    }

    const DeviceInfo& info() const noexcept override { return own; }

    DeviceReading read(double, double) noexcept override
    {
        const hd::Functions& hd = session_.hd_;
        hd.hdMakeCurrentDevice(handle);
        hd.hdBeginFrame(handle);
        DeviceReading fresh;
        std::array<double, 16> transform {};
        int buttons = 0;
        hd.hdGetDoublev(hd::kPosition, fresh.position.data());
        hd.hdGetDoublev(hd::kVelocity, fresh.velocity.data());
        hd.hdGetDoublev(hd::kTransform, transform.data());
        hd.hdGetIntegerv(hd::kButtons, &buttons);
        for (int column = 0; column < 3; ++column)
            for (int row = 0; row < 3; ++row)
                fresh.orientation(row, column) = transform[static_cast<std::size_t>(4 * column + row)];
        fresh.buttons = static_cast<std::uint32_t>(buttons);
        fresh.trouble = trouble;
        const Vec3 beyond = (own.workspace.low - fresh.position).cwiseMax(fresh.position - own.workspace.high);
        if (fresh.trouble == DeviceTrouble::none && beyond.maxCoeff() > kOverrun)
            fresh.trouble = DeviceTrouble::over_limit;
        if (fresh.trouble == DeviceTrouble::over_limit)
            trouble = DeviceTrouble::none; // the device recovers by itself, and reports again if it does not
        return fresh;
    }

    Vec3 write(const Vec3& wanted) noexcept override
    {
        force = wanted.allFinite() ? Vec3(session_.gain_ * clamped(wanted, own.limits.max_force)) : Vec3(Vec3::Zero());
        session_.hd_.hdMakeCurrentDevice(handle);
        session_.hd_.hdSetDoublev(hd::kForce, force.data());
        session_.hd_.hdEndFrame(handle);
        return force;
    }

    hd::Handle handle;
    DeviceInfo own;
    DeviceTrouble trouble = DeviceTrouble::none; ///< `lost` is permanent
    Vec3 force = Vec3::Zero();

private:
    HdSession& session_;
};

HdSession::HdSession(const std::vector<HdDeviceRequest>& requests, const HdOptions& options)
    : library_(options.libraries)
    , hd_(library_.functions())
    , options_(options)
    , timer_(std::make_unique<TickTimer>(1.0 / options.rate_hz, options.clock))
{
    if (requests.empty())
        throw InputError("no device was asked for");
    const PlainNumbers plain;
    try {
        for (const HdDeviceRequest& request : requests)
            initialise(request);
    } catch (...) {
        for (const auto& touch : devices_)
            hd_.hdDisableDevice(touch->handle);
        throw;
    }
}

HdSession::~HdSession()
{
    stop();
    for (const auto& touch : devices_)
        hd_.hdDisableDevice(touch->handle);
}

Device& HdSession::device(std::size_t i) { return *devices_.at(i); }

void HdSession::check_queue(const std::string& what) const
{
    hd::ErrorCode first = hd::kSuccess;
    int internal = 0;
    for (int i = 0; i < kQueueLimit; ++i) {
        const hd::ErrorInfo error = hd_.hdGetError();
        if (error.code == hd::kSuccess)
            break;
        if (first == hd::kSuccess) {
            first = error.code;
            internal = error.internal;
        }
    }
    if (first == hd::kSuccess)
        return;
    const char* const theirs = hd_.hdGetErrorString(first);
    std::string advice;
    if (first == hd::kCommError || first == hd::kCommConfigError || first == hd::kDeviceFault)
        advice = "; is it plugged in and configured?";
    else if (first == hd::kAlreadyInitiated)
        advice = "; end the other program that uses it";
    throw IoError(what + ": " + meaning(first) + " (HDAPI " + hex(first) + ", internal " + std::to_string(internal)
            + (theirs != nullptr && *theirs != '\0' ? ", \"" + std::string(theirs) + "\"" : "") + ")" + advice,
        library_.name());
}

hd::Handle HdSession::handle_of(const HdDeviceRequest& request)
{
    // Without a name, the serial number is searched for under the names that the vendor's set-up gives.
    std::vector<std::string> names { request.name };
    if (request.name.empty() && !request.serial.empty())
        names = { "", "Default Device", "Left Device", "Right Device", "Phantom1", "Phantom2" };
    std::string seen;
    for (const std::string& name : names) {
        for (int i = 0; i < kQueueLimit && hd_.hdGetError().code != hd::kSuccess; ++i)
            ; // removes old errors, which do not belong to this call
        const hd::Handle handle = hd_.hdInitDevice(name.empty() ? nullptr : name.c_str());
        if (handle == hd::kInvalidHandle) {
            if (names.size() == 1)
                check_queue("device '" + (name.empty() ? std::string("default") : name) + "' cannot be initialised");
            continue;
        }
        const bool known
            = std::any_of(devices_.begin(), devices_.end(), [&](const auto& d) { return d->handle == handle; });
        hd_.hdMakeCurrentDevice(handle);
        const char* const serial = hd_.hdGetString(hd::kSerial);
        if (!known && (request.serial.empty() || (serial != nullptr && request.serial == serial)))
            return handle;
        if (!known)
            hd_.hdDisableDevice(handle);
        seen
            += (seen.empty() ? "; there is " : ", ") + std::string(serial != nullptr ? serial : "one without a number");
    }
    throw IoError("device '" + (request.serial.empty() ? request.name : request.serial) + "' was not found" + seen,
        library_.name());
}

void HdSession::initialise(const HdDeviceRequest& request)
{
    auto touch = std::make_unique<Touch>(*this, handle_of(request));
    hd_.hdMakeCurrentDevice(touch->handle);
    DeviceInfo& info = touch->own;
    const auto text = [&](hd::Enum what) {
        const char* const value = hd_.hdGetString(what);
        return std::string(value != nullptr ? value : "");
    };
    const auto number = [&](hd::Enum what, double& value) {
        double got = 0.0;
        hd_.hdGetDoublev(what, &got);
        if (got > 0.0 && std::isfinite(got)) // some models report nothing; the value of the data sheet stays then
            value = got;
    };
    info.name = request.name.empty() ? "default" : request.name;
    info.model = text(hd::kModel);
    info.serial = text(hd::kSerial);
    info.rate_hz = options_.rate_hz;
    number(hd::kMaxForce, info.limits.max_force);
    number(hd::kContinuousForce, info.limits.continuous_force);
    number(hd::kMaxStiffness, info.limits.max_stiffness);
    number(hd::kMaxDamping, info.limits.max_damping);
    info.limits.delay_ticks = 1;
    std::array<double, 6> box {};
    hd_.hdGetDoublev(hd::kUsableWorkspace, box.data());
    if (workspace_of(box).low.array().isFinite().all()
        && (workspace_of(box).high - workspace_of(box).low).minCoeff() > 0.0)
        info.workspace = workspace_of(box);
    // The safety functions are enabled before the force.
    hd_.hdEnable(hd::kForceClamping);
    hd_.hdEnable(hd::kSoftwareForceLimit);
    hd_.hdEnable(hd::kForceRamping);
    devices_.push_back(std::move(touch));
    check_queue("device '" + info.name + "' does not answer as it should");
    calibrate(*devices_.back());
}

void HdSession::calibrate(Touch& touch)
{
    hd_.hdMakeCurrentDevice(touch.handle);
    const auto start = std::chrono::steady_clock::now();
    hd::Enum state = hd_.hdCheckCalibration();
    while (state != hd::kCalibrationOk) {
        const hd::Enum style = hd_.hdCheckCalibrationStyle();
        if (state == hd::kCalibrationNeedsUpdate)
            hd_.hdUpdateCalibration(style);
        state = hd_.hdCheckCalibration();
        if (state == hd::kCalibrationOk)
            break;
        if (std::chrono::steady_clock::now() - start > options_.calibration_limit)
            throw IoError("device '" + touch.own.name + "' is not calibrated: "
                    + ((style & hd::kStyleInkwell) != 0 ? "put the stylus into its inkwell and start again"
                                                        : "run the vendor's diagnostics"),
                library_.name());
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    check_queue("device '" + touch.own.name + "' cannot be calibrated");
}

std::uint32_t HdSession::callback(void* session) noexcept
{
    static_cast<HdSession*>(session)->run_tick();
    return hd::kCallbackContinue;
}

void HdSession::run_tick() noexcept
{
    const double step = timer_->begin();
    calls_.fetch_add(1, std::memory_order_relaxed);
    const bool stopping = stopping_.load(std::memory_order_relaxed);
    const double ramp_step = std::min(step, 2.0 / options_.rate_hz); // a late tick must not shorten a ramp
    gain_
        = std::clamp(gain_ + (stopping ? -ramp_step / options_.ramp_down_s : ramp_step / options_.ramp_up_s), 0.0, 1.0);
    ticked_->tick(timer_->time_s(), step);
    drain_errors();
    if (stopping && gain_ == 0.0)
        faded_.store(true, std::memory_order_release);
}

void HdSession::drain_errors() noexcept
{
    for (int i = 0; i < kQueueLimit; ++i) {
        const hd::ErrorInfo error = hd_.hdGetError();
        if (error.code == hd::kSuccess)
            return;
        HdProblem problem { error.code, error.internal, devices_.size(), trouble_of(error.code) };
        for (std::size_t d = 0; d < devices_.size(); ++d)
            if (devices_[d]->handle == error.device) {
                problem.device = d;
                if (devices_[d]->trouble != DeviceTrouble::lost && problem.trouble != DeviceTrouble::none)
                    devices_[d]->trouble = problem.trouble;
            }
        const std::size_t at = written_.load(std::memory_order_relaxed);
        if (at - read_.load(std::memory_order_acquire) < kProblems) {
            problems_[at % kProblems] = problem;
            written_.store(at + 1, std::memory_order_release);
        }
    }
}

std::vector<HdProblem> HdSession::take_problems()
{
    std::vector<HdProblem> taken;
    std::size_t at = read_.load(std::memory_order_relaxed);
    for (const std::size_t end = written_.load(std::memory_order_acquire); at != end; ++at)
        taken.push_back(problems_[at % kProblems]);
    read_.store(at, std::memory_order_release);
    return taken;
}

void HdSession::start(Ticked& ticked)
{
    if (running_)
        throw InputError("the devices run already");
    ticked_ = &ticked;
    timer_ = std::make_unique<TickTimer>(1.0 / options_.rate_hz, options_.clock);
    gain_ = 0.0;
    stopping_ = false;
    faded_ = false;
    for (const auto& touch : devices_) {
        hd_.hdMakeCurrentDevice(touch->handle);
        hd_.hdEnable(hd::kForceOutput);
    }
    hd_.hdSetSchedulerRate(options_.rate_hz);
    scheduled_ = hd_.hdScheduleAsynchronous(&HdSession::callback, this, hd::kHighestPriority);
    hd_.hdStartScheduler();
    running_ = true;
    try {
        check_queue("the devices' scheduler cannot be started");
    } catch (...) {
        stop();
        throw;
    }
}

void HdSession::stop() noexcept
{
    if (!running_)
        return;
    stopping_ = true;
    // Waits while the scheduler calls, however slowly. The scheduler of an unplugged device may never call again.
    auto last_call = std::chrono::steady_clock::now();
    std::uint64_t calls = calls_.load();
    while (!faded_.load(std::memory_order_acquire) && std::chrono::steady_clock::now() - last_call < kSilentScheduler) {
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
        if (const std::uint64_t now = calls_.load(); now != calls) {
            calls = now;
            last_call = std::chrono::steady_clock::now();
        }
    }
    hd_.hdUnschedule(scheduled_);
    hd_.hdStopScheduler();
    for (const auto& touch : devices_) {
        hd_.hdMakeCurrentDevice(touch->handle);
        hd_.hdDisable(hd::kForceOutput);
    }
    running_ = false;
}

} // namespace retractor::haptics
