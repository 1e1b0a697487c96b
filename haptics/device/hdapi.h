#pragma once
// The part of 3D Systems' HDAPI that we use, declared from its documented interface. The library is loaded at run time,
// so that a build needs nothing of the vendor's. Platform: x86-64, System V. Units of the interface: mm, mm/s, N, N/mm.

#include <cstdint>

namespace retractor::haptics::hd {

using Handle = std::uint32_t;
using Enum = std::uint32_t;
using ErrorCode = std::uint32_t;
using Boolean = unsigned char;
using SchedulerHandle = unsigned long;
using Callback = std::uint32_t (*)(void*);

/// Returned by value.
struct ErrorInfo {
    ErrorCode code;
    int internal;
    Handle device;
};

constexpr Handle kInvalidHandle = 0xFFFFFFFFu;
constexpr std::uint32_t kCallbackDone = 0, kCallbackContinue = 1;
constexpr std::uint32_t kCheckStatus = 0;
constexpr std::uint16_t kHighestPriority = 0xFFFF;

// Error codes.
constexpr ErrorCode kSuccess = 0x0000, kInvalidInputType = 0x0103;
constexpr ErrorCode kWarmMotors = 0x0200, kExceededForce = 0x0201, kExceededImpulse = 0x0202,
                    kExceededVelocity = 0x0203, kForceError = 0x0204;
constexpr ErrorCode kDeviceFault = 0x0300, kAlreadyInitiated = 0x0301, kCommError = 0x0302, kCommConfigError = 0x0303,
                    kTimerError = 0x0304;
constexpr ErrorCode kIllegalBegin = 0x0400, kIllegalEnd = 0x0401, kFrameError = 0x0402;
constexpr ErrorCode kInvalidPriority = 0x0500, kSchedulerFull = 0x0501, kInvalidLicense = 0x0600;

// State of a device.
constexpr Enum kButtons = 0x2000, kPosition = 0x2050, kVelocity = 0x2051, kTransform = 0x2052;
// Properties of a device.
constexpr Enum kModel = 0x2501, kSerial = 0x2504, kUsableWorkspace = 0x2551, kMaxWorkspace = 0x2550;
constexpr Enum kMaxStiffness = 0x2602, kMaxForce = 0x2603, kContinuousForce = 0x2604, kMaxDamping = 0x2609;
// Force output and its safety functions.
constexpr Enum kForce = 0x2700;
constexpr Enum kForceOutput = 0x4000, kForceClamping = 0x4001, kForceRamping = 0x4002, kSoftwareForceLimit = 0x4003;
// Calibration.
constexpr Enum kCalibrationOk = 0x5000, kCalibrationNeedsUpdate = 0x5001, kCalibrationNeedsInput = 0x5002;
constexpr Enum kStyleInkwell = 4;

/// All functions of the library that we call; HdLibrary fills the struct.
struct Functions {
    Handle (*hdInitDevice)(const char*);
    void (*hdDisableDevice)(Handle);
    void (*hdMakeCurrentDevice)(Handle);
    void (*hdBeginFrame)(Handle);
    void (*hdEndFrame)(Handle);
    ErrorInfo (*hdGetError)();
    const char* (*hdGetErrorString)(ErrorCode);
    void (*hdEnable)(Enum);
    void (*hdDisable)(Enum);
    void (*hdGetIntegerv)(Enum, int*);
    void (*hdGetDoublev)(Enum, double*);
    const char* (*hdGetString)(Enum);
    void (*hdSetDoublev)(Enum, const double*);
    Enum (*hdCheckCalibration)();
    Enum (*hdCheckCalibrationStyle)();
    void (*hdUpdateCalibration)(Enum);
    void (*hdStartScheduler)();
    void (*hdStopScheduler)();
    void (*hdSetSchedulerRate)(unsigned long);
    SchedulerHandle (*hdScheduleAsynchronous)(Callback, void*, std::uint16_t);
    void (*hdUnschedule)(SchedulerHandle);
    Boolean (*hdWaitForCompletion)(SchedulerHandle, std::uint32_t);
};

} // namespace retractor::haptics::hd
