// A shared library with HDAPI's symbols and a simulated Touch behind them: noise, encoder steps of 0.055 mm, one tick
// of latency, saturation at 3.3 N, and faults on demand. It notes wrong use, so that every line of the driver is held
// to it.

#include "tests/haptics/device/simulated_hd.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <mutex>
#include <set>
#include <string>
#include <thread>

namespace {

constexpr int kDevices = 2;
constexpr double kResolution = 0.055, kMaxForce = 3.3, kMass = 45e-6, kSpring = 0.4, kDamping = 6e-3; // tonne, N/mm
constexpr std::uint32_t kInvalid = 0xFFFFFFFFu;

struct ErrorInfo {
    std::uint32_t code;
    int internal;
    std::uint32_t device;
};

using Vector = std::array<double, 3>;

struct Touch {
    const char* name = "";
    const char* serial = "";
    bool initialised = false, unplugged = false, in_frame = false, force_on = false;
    std::set<std::uint32_t> capabilities;
    Vector target {}, position {}, velocity {}, asked {}, motor {}, offset {}, encoder {};
    int buttons = 0, calibration = 0;
};

std::recursive_mutex mutex;
std::array<Touch, kDevices> healthy()
{
    std::array<Touch, kDevices> both {};
    both[0].name = "Default Device";
    both[0].serial = "100-1";
    both[1].name = "Left Device";
    both[1].serial = "100-2";
    // For a program that cannot tell where the hands mean to be: how far down, mm.
    if (const char* const down = std::getenv("SIMULATED_DOWN"); down != nullptr)
        for (Touch& touch : both)
            touch.target[1] = -std::strtod(down, nullptr);
    return both;
}
std::array<Touch, kDevices> touches = healthy();
std::deque<ErrorInfo> errors;
std::string violations;
std::uint32_t current = kInvalid, refusal = 0;
std::uint32_t (*scheduled)(void*) = nullptr;
void* scheduled_data = nullptr;
std::atomic<bool> runs { false };
std::thread scheduler;
bool threaded = true;
unsigned long rate = 1000;
double noise = 0.0;
std::uint64_t random_state = 1;
std::atomic<long> ticks { 0 };

void violate(const std::string& what)
{
    if (violations.find(what) == std::string::npos)
        violations += what + "\n";
}

double normal_like()
{
    double sum = -6.0;
    for (int i = 0; i < 12; ++i) {
        random_state = random_state * 6364136223846793005u + 1442695040888963407u;
        sum += static_cast<double>(random_state >> 11) / 9007199254740992.0;
    }
    return sum;
}

Touch* touch_of(std::uint32_t handle)
{
    return handle < kDevices && touches[handle].initialised ? &touches[handle] : nullptr;
}
void post(std::uint32_t code, std::uint32_t device, int internal = 0) { errors.push_back({ code, internal, device }); }

Touch* in_frame(const char* call)
{
    Touch* const touch = touch_of(current);
    if (touch == nullptr)
        post(0x0104, current);
    else if (scheduled != nullptr && runs && !touch->in_frame) {
        violate(std::string(call) + " outside a frame");
        post(0x0402, current);
    }
    return touch;
}

void move(Touch& touch)
{
    constexpr int kSubsteps = 20;
    const double dt = 1.0 / static_cast<double>(rate) / kSubsteps;
    for (int i = 0; i < kSubsteps; ++i)
        for (std::size_t a = 0; a < 3; ++a) {
            const double push
                = touch.motor[a] + kSpring * (touch.target[a] - touch.position[a]) - kDamping * touch.velocity[a];
            touch.velocity[a] += dt / kMass * push;
            touch.position[a] += dt * touch.velocity[a];
        }
    for (std::size_t a = 0; a < 3; ++a)
        touch.encoder[a]
            = kResolution * std::round((touch.position[a] + noise * normal_like()) / kResolution) + touch.offset[a];
    // What was asked for in this tick drives from the next one on.
    touch.motor = touch.force_on && !touch.unplugged ? touch.asked : Vector {};
    const double size = std::hypot(touch.motor[0], touch.motor[1], touch.motor[2]);
    if (size > kMaxForce)
        for (double& f : touch.motor)
            f *= kMaxForce / size;
}

void run_once()
{
    const std::lock_guard lock(mutex);
    ++ticks;
    for (Touch& touch : touches)
        move(touch);
    if (scheduled != nullptr && scheduled(scheduled_data) == 0)
        scheduled = nullptr;
    for (const Touch& touch : touches)
        if (touch.in_frame)
            violate("a frame is left open");
}

} // namespace

extern "C" {

void simulated_reset()
{
    const std::lock_guard lock(mutex);
    touches = healthy();
    errors.clear();
    violations.clear();
    current = kInvalid;
    refusal = 0;
    scheduled = nullptr;
    threaded = true;
    noise = 0.0;
    random_state = 1;
    ticks = 0;
}
void simulated_run(int count)
{
    for (int i = 0; i < count; ++i)
        if (runs)
            run_once();
}
void simulated_threaded(int own_thread) { threaded = own_thread != 0; }
void simulated_target(int device, double x, double y, double z)
{
    const std::lock_guard lock(mutex);
    touches.at(static_cast<std::size_t>(device)).target = { x, y, z };
}
void simulated_buttons(int device, int buttons) { touches.at(static_cast<std::size_t>(device)).buttons = buttons; }
void simulated_post_error(int device, unsigned code, int internal)
{
    const std::lock_guard lock(mutex);
    post(code, static_cast<std::uint32_t>(device), internal);
}
void simulated_unplug(int device)
{
    const std::lock_guard lock(mutex);
    touches.at(static_cast<std::size_t>(device)).unplugged = true;
}
void simulated_offset(int device, double x, double y, double z)
{
    const std::lock_guard lock(mutex);
    touches.at(static_cast<std::size_t>(device)).offset = { x, y, z };
}
void simulated_refuse(unsigned code) { refusal = code; }
void simulated_calibration(int device, int state) { touches.at(static_cast<std::size_t>(device)).calibration = state; }
void simulated_noise(double rms_mm) { noise = rms_mm; }
void simulated_motor_force(int device, double* force)
{
    const std::lock_guard lock(mutex);
    std::copy_n(touches.at(static_cast<std::size_t>(device)).motor.data(), 3, force);
}
void simulated_position(int device, double* position)
{
    const std::lock_guard lock(mutex);
    std::copy_n(touches.at(static_cast<std::size_t>(device)).position.data(), 3, position);
}
const char* simulated_violations() { return violations.c_str(); }
int simulated_initialised(int device) { return touches.at(static_cast<std::size_t>(device)).initialised ? 1 : 0; }
long simulated_ticks() { return ticks; }
int simulated_scheduler_runs() { return runs ? 1 : 0; }

// ---- HDAPI ----

std::uint32_t hdInitDevice(const char* name)
{
    if (refusal != 0) {
        post(refusal, kInvalid, 7);
        return kInvalid;
    }
    for (std::size_t i = 0; i < kDevices; ++i)
        if (i == 0 ? name == nullptr || std::strcmp(name, touches[i].name) == 0
                   : name != nullptr && std::strcmp(name, touches[i].name) == 0) {
            if (touches[i].initialised) {
                post(0x0301, static_cast<std::uint32_t>(i));
                return kInvalid;
            }
            touches[i].initialised = true;
            touches[i].position = touches[i].target;
            return current = static_cast<std::uint32_t>(i);
        }
    post(0x0101, kInvalid);
    return kInvalid;
}
void hdDisableDevice(std::uint32_t handle)
{
    if (runs)
        violate("a device is disabled while the scheduler runs");
    if (Touch* const touch = touch_of(handle))
        touch->initialised = false;
    else
        post(0x0104, handle);
}
void hdMakeCurrentDevice(std::uint32_t handle) { current = handle; }
std::uint32_t hdGetCurrentDevice() { return current; }
void hdBeginFrame(std::uint32_t handle)
{
    Touch* const touch = touch_of(handle);
    if (touch == nullptr)
        return post(0x0104, handle);
    if (touch->in_frame)
        post(0x0400, handle);
    touch->in_frame = true;
    if (touch->unplugged)
        post(0x0302, handle, -1);
}
void hdEndFrame(std::uint32_t handle)
{
    Touch* const touch = touch_of(handle);
    if (touch == nullptr || !touch->in_frame)
        return post(0x0401, handle);
    touch->in_frame = false;
}
ErrorInfo hdGetError()
{
    const std::lock_guard lock(mutex);
    if (errors.empty())
        return { 0, 0, current };
    const ErrorInfo error = errors.front();
    errors.pop_front();
    return error;
}
const char* hdGetErrorString(std::uint32_t code) { return code == 0x0302 ? "Communication error" : ""; }
void hdEnable(std::uint32_t capability)
{
    Touch* const touch = touch_of(current);
    if (touch == nullptr)
        return post(0x0104, current);
    touch->capabilities.insert(capability);
    if (capability == 0x4000) {
        if (!touch->capabilities.contains(0x4001) || !touch->capabilities.contains(0x4003))
            violate("force is on before what guards it");
        touch->force_on = true;
    }
}
void hdDisable(std::uint32_t capability)
{
    Touch* const touch = touch_of(current);
    if (touch == nullptr)
        return post(0x0104, current);
    touch->capabilities.erase(capability);
    if (capability == 0x4000)
        touch->force_on = false;
}
void hdGetIntegerv(std::uint32_t what, int* value)
{
    Touch* const touch = in_frame("hdGetIntegerv");
    if (touch != nullptr && what == 0x2000)
        *value = touch->buttons;
    else if (touch != nullptr)
        post(0x0103, current);
}
void hdGetDoublev(std::uint32_t what, double* value)
{
    Touch* const touch = what < 0x2500 ? in_frame("hdGetDoublev") : touch_of(current);
    if (touch == nullptr)
        return;
    switch (what) {
    case 0x2050:
        std::copy_n(touch->encoder.data(), 3, value);
        return;
    case 0x2051:
        std::copy_n(touch->velocity.data(), 3, value);
        return;
    case 0x2052: { // column-major; the stylus' x axis lies along the device's y
        const std::array<double, 16> transform { 0, 1, 0, 0, -1, 0, 0, 0, 0, 0, 1, 0, touch->encoder[0],
            touch->encoder[1], touch->encoder[2], 1 };
        std::copy_n(transform.data(), 16, value);
        return;
    }
    case 0x2551: {
        const std::array<double, 6> box { -80, -60, -35, 80, 60, 35 };
        std::copy_n(box.data(), 6, value);
        return;
    }
    case 0x2602:
        *value = 0.5;
        return;
    case 0x2603:
        *value = kMaxForce;
        return;
    case 0x2604:
        *value = 0.88;
        return;
    case 0x2609:
        *value = 0.0; // not told by this model
        return;
    default:
        post(0x0103, current);
    }
}
const char* hdGetString(std::uint32_t what)
{
    const Touch* const touch = touch_of(current);
    if (touch == nullptr)
        return nullptr;
    return what == 0x2501 ? "Simulated Touch" : what == 0x2504 ? touch->serial : "";
}
void hdSetDoublev(std::uint32_t what, const double* value)
{
    Touch* const touch = in_frame("hdSetDoublev");
    if (touch == nullptr || what != 0x2700)
        return post(0x0100, current);
    std::copy_n(value, 3, touch->asked.data());
    if (!std::isfinite(value[0] + value[1] + value[2]))
        violate("a force that is not finite");
    if (std::hypot(value[0], value[1], value[2]) > kMaxForce * (1 + 1e-9))
        post(0x0201, current);
}
std::uint32_t hdCheckCalibration()
{
    const Touch* const touch = touch_of(current);
    const int state = touch != nullptr ? touch->calibration : 2;
    return state == 0 ? 0x5000u : state == 2 ? 0x5002u : 0x5001u;
}
std::uint32_t hdCheckCalibrationStyle()
{
    const Touch* const touch = touch_of(current);
    return touch != nullptr && touch->calibration == 2 ? 4u : 2u;
}
void hdUpdateCalibration(std::uint32_t)
{
    if (Touch* const touch = touch_of(current); touch != nullptr && touch->calibration == 1)
        touch->calibration = 0;
}
void hdStartScheduler()
{
    if (runs.exchange(true))
        violate("the scheduler is started twice");
    if (!threaded)
        return;
    scheduler = std::thread([] {
        while (runs) {
            run_once();
            // The rate of the scheduler that is stood in for; no test asks for more than that it goes on.
            std::this_thread::sleep_for(std::chrono::microseconds(1000000 / rate));
        }
    });
}
void hdStopScheduler()
{
    if (scheduled != nullptr)
        violate("the scheduler is stopped with a callback in it");
    runs = false;
    if (scheduler.joinable())
        scheduler.join();
}
void hdSetSchedulerRate(unsigned long hz) { rate = hz; }
unsigned long hdScheduleAsynchronous(std::uint32_t (*callback)(void*), void* data, std::uint16_t priority)
{
    const std::lock_guard lock(mutex);
    if (scheduled != nullptr)
        violate("two callbacks interleave");
    if (priority < 0x8000)
        violate("the servo has a low priority");
    scheduled = callback;
    scheduled_data = data;
    return 0x123456789aul; // more than 32 bits
}
void hdUnschedule(unsigned long handle)
{
    const std::lock_guard lock(mutex);
    if (handle != 0x123456789aul)
        violate("another scheduler handle than was given");
    for (const Touch& touch : touches)
        if (touch.initialised && !touch.unplugged && std::hypot(touch.asked[0], touch.asked[1], touch.asked[2]) != 0.0)
            violate("unscheduled with force on");
    scheduled = nullptr;
}
unsigned char hdWaitForCompletion(unsigned long, std::uint32_t) { return 0; }
}
