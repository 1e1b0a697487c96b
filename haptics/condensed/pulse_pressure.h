#pragma once
// Blood pressure over time: one beat, repeated. Files and people speak of mmHg and beats per minute; inside it is MPa.

#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

namespace retractor::haptics {

inline constexpr double kMPaPerMmHg = 133.322387415e-6;

class PulsePressure {
public:
    /// Aortic pressure of a resting adult. The shape is that of a three-element windkessel (characteristic impedance
    /// 0.05 mmHg s/ml, resistance 1 mmHg s/ml, compliance 1.5 ml/mmHg: the normal ranges in [Westerhof, Lankhaar,
    /// Westerhof 2009, doi 10.1007/s11517-008-0359-2]) behind a heart that ejects in a half sine over 0.3 s, with a
    /// short back flow that closes the valve; between `diastolic_mmHg` and `systolic_mmHg`.
    /// @throws InputError when diastole is not below systole, or on a heart rate outside 20 to 300 per minute.
    static PulsePressure aortic(
        double heart_rate_per_min = 75.0, double diastolic_mmHg = 80.0, double systolic_mmHg = 120.0);

    /// The same pressure at all times.
    static PulsePressure constant(double mmHg);

    /// Lines "time_s,pressure_mmHg" after a header of these two names; lines that begin with # are left out. Times
    /// rise; the last line closes the beat: its pressure is that of the first (within 1 mmHg, else it is refused).
    /// @param heart_rate_per_min stretches the beat; 0: as it is in the file.
    /// @throws IoError when the file cannot be read; InputError naming its line.
    static PulsePressure read_csv(const std::filesystem::path& file, double heart_rate_per_min = 0.0);

    /// MPa; any time, also a negative one. Linear between samples. Allocates nothing.
    double at(double time_s) const noexcept;

    double period_s() const { return period_s_; }
    /// How much faster than its own the curve is for this many beats per minute. @throws InputError outside 20 to 300.
    double rate_for(double heart_rate_per_min) const;
    double lowest_mmHg() const;
    double highest_mmHg() const;
    /// What the curve is, for a report.
    const std::string& source() const { return source_; }

private:
    /// @param samples at equal steps over one beat, the last of which is followed by the first; mmHg
    PulsePressure(std::vector<double> samples, double period_s, std::string source);

    std::vector<double> samples_; ///< MPa
    double period_s_ = 1.0;
    std::string source_;
};

/// The time a heart keeps: the clock's, until it is told to beat faster or slower; from then on it goes on from where
/// it was, without a jump.
class BeatClock {
public:
    /// Any thread, from the next at() on. @pre rate is positive; 1 is the curve's own
    void set_rate(double rate) noexcept { wanted_.store(rate, std::memory_order_relaxed); }
    /// Servo thread. Exactly the clock's time as long as the rate was never changed.
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
