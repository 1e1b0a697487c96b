#pragma once
// Blood pressure over time: one beat, repeated. Files and the user interface use mmHg and beats per minute; the code
// uses MPa.

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

namespace retractor::haptics {

inline constexpr double kMPaPerMmHg = 133.322387415e-6;

class PulsePressure {
public:
    /// Aortic pressure of a resting adult, between `diastolic_mmHg` and `systolic_mmHg`. The shape is that of a
    /// three-element windkessel: characteristic impedance 0.05 mmHg s/ml, resistance 1 mmHg s/ml, compliance 1.5
    /// ml/mmHg, in the normal ranges of Westerhof, Lankhaar, Westerhof 2009 (doi 10.1007/s11517-008-0359-2). The heart
    /// ejects in a half sine over 0.3 s, with a short back flow that closes the valve.
    /// @throws InputError when diastole is not below systole, or on a heart rate outside 20 to 300 per minute
    static PulsePressure aortic(
        double heart_rate_per_min = 75.0, double diastolic_mmHg = 80.0, double systolic_mmHg = 120.0);

    /// A constant pressure.
    static PulsePressure constant(double mmHg);

    /// Reads a beat from lines "time_s,pressure_mmHg" after a header with these two names. Lines that begin with # are
    /// skipped. Times must rise. The last line closes the beat: its pressure must equal the first pressure within 1
    /// mmHg.
    /// @param heart_rate_per_min stretches the beat to this rate; 0 keeps the rate of the file
    /// @throws IoError when the file cannot be read; InputError naming the line
    static PulsePressure read_csv(const std::filesystem::path& file, double heart_rate_per_min = 0.0);

    /// Pressure at any time, also a negative one, MPa. Linear between samples. Allocates nothing.
    double at(double time_s) const noexcept;

    double period_s() const { return period_s_; }
    /// Ratio of this heart rate to the curve's own rate. @throws InputError outside 20 to 300 per minute.
    double rate_for(double heart_rate_per_min) const;
    double lowest_mmHg() const;
    double highest_mmHg() const;
    /// Description of the curve for a report.
    const std::string& source() const { return source_; }

private:
    /// @param samples mmHg, at equal steps over one beat; the last sample is followed by the first
    PulsePressure(std::vector<double> samples, double period_s, std::string source);

    std::vector<double> samples_; ///< MPa
    double period_s_ = 1.0;
    std::string source_;
};

/// The time of the beating heart. It equals the clock's time until the rate is changed; then it continues at the new
/// rate without a jump.
class BeatClock {
public:
    /// Any thread; takes effect at the next at(). @pre rate is positive; 1 is the curve's own rate
    void set_rate(double rate) noexcept { wanted_.store(rate, std::memory_order_relaxed); }
    /// Servo thread. Equals the clock's time exactly while the rate was never changed.
    double at(double time_s) noexcept
    {
        if (const double wanted = wanted_.load(std::memory_order_relaxed); wanted != rate_) {
            beaten_ += rate_ * (time_s - since_);
            since_ = time_s;
            rate_ = wanted;
        }
        return beaten_ + rate_ * (time_s - since_);
    }

private:
    std::atomic<double> wanted_ { 1.0 };
    double rate_ = 1.0, beaten_ = 0.0, since_ = 0.0;
};

} // namespace retractor::haptics
