#include "haptics/condensed/pulse_pressure.h"

#include "mesh/base/error.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdlib>
#include <fstream>
#include <numbers>
#include <utility>

namespace retractor::haptics {

namespace {

    constexpr std::size_t kSamples = 512; ///< per beat: steps of 1.6 ms at 75 beats per minute

    double period_of(double heart_rate_per_min)
    {
        if (!(heart_rate_per_min >= 20.0 && heart_rate_per_min <= 300.0))
            throw InputError("a heart rate lies between 20 and 300 per minute", "heart rate");
        return 60.0 / heart_rate_per_min;
    }

    /// Flow out of the heart at a time of a beat of 0.8 s, ml/s.
    double ejection(double t)
    {
        constexpr double kEjection = 0.30, kBackFlow = 0.04, kPeak = 420.0, kBackPeak = 90.0;
        if (t < kEjection)
            return kPeak * std::sin(std::numbers::pi * t / kEjection);
        if (t < kEjection + kBackFlow)
            return -kBackPeak * std::sin(std::numbers::pi * (t - kEjection) / kBackFlow);
        return 0.0;
    }

    /// Pressure over one beat of 0.8 s in the periodic state, mmHg.
    std::vector<double> windkessel()
    {
        constexpr double kImpedance = 0.05, kResistance = 1.0, kCompliance = 1.5, kBeat = 0.8;
        // Twenty beats are fifteen time constants, so the start has no influence.
        constexpr int kSubsteps = 16, kBeats = 20;
        const double step = kBeat / (static_cast<double>(kSamples) * kSubsteps);
        std::vector<double> pressure(kSamples);
        double stored = 90.0; // pressure of the compliance, mmHg
        for (int beat = 0; beat < kBeats; ++beat)
            for (std::size_t i = 0; i < kSamples; ++i) {
                for (int s = 0; s < kSubsteps; ++s) {
                    const double t = (static_cast<double>(i) * kSubsteps + s) * step;
                    if (s == 0)
                        pressure[i] = stored + kImpedance * ejection(t);
                    const double middle = stored + 0.5 * step * (ejection(t) - stored / kResistance) / kCompliance;
                    stored += step * (ejection(t + 0.5 * step) - middle / kResistance) / kCompliance;
                }
            }
        return pressure;
    }

    struct CsvRow {
        double time = 0.0, pressure = 0.0;
    };

    /// @return false when the text is not exactly two finite numbers
    bool parse_row(const std::string& line, CsvRow& row)
    {
        char* end = nullptr;
        row.time = std::strtod(line.c_str(), &end);
        if (end == line.c_str() || *end != ',')
            return false;
        const char* second = end + 1;
        row.pressure = std::strtod(second, &end);
        while (end != nullptr && (*end == ' ' || *end == '\r'))
            ++end;
        return end != second && *end == '\0' && std::isfinite(row.time) && std::isfinite(row.pressure);
    }

    std::vector<CsvRow> read_rows(const std::filesystem::path& file)
    {
        std::ifstream in(file);
        if (!in)
            throw IoError("cannot be read", file.string());
        std::vector<CsvRow> rows;
        std::string line;
        bool header = false;
        for (int number = 1; std::getline(in, line); ++number) {
            if (line.empty() || line == "\r" || line.front() == '#')
                continue;
            const std::string where = file.string() + ", line " + std::to_string(number);
            if (!header) {
                if (line.rfind("time_s,pressure_mmHg", 0) != 0)
                    throw InputError("a pressure curve begins with the line time_s,pressure_mmHg", where);
                header = true;
                continue;
            }
            CsvRow row;
            if (!parse_row(line, row))
                throw InputError("two finite numbers are needed, time_s and pressure_mmHg: \"" + line + '"', where);
            if (!rows.empty() && !(row.time > rows.back().time))
                throw InputError("times must rise", where);
            rows.push_back(row);
        }
        if (rows.size() < 3)
            throw InputError("a beat needs three lines at least", file.string());
        return rows;
    }

} // namespace

PulsePressure::PulsePressure(std::vector<double> samples, double period_s, std::string source)
    : samples_(std::move(samples))
    , period_s_(period_s)
    , source_(std::move(source))
{
    for (double& p : samples_)
        p *= kMPaPerMmHg;
}

PulsePressure PulsePressure::aortic(double heart_rate_per_min, double diastolic_mmHg, double systolic_mmHg)
{
    const double period = period_of(heart_rate_per_min);
    if (!(std::isfinite(systolic_mmHg) && std::isfinite(diastolic_mmHg) && diastolic_mmHg < systolic_mmHg))
        throw InputError("the diastolic pressure must lie below the systolic one", "pressure");
    std::vector<double> samples = windkessel();
    const auto [low, high] = std::minmax_element(samples.begin(), samples.end());
    const double from = *low, scale = (systolic_mmHg - diastolic_mmHg) / (*high - *low);
    for (double& p : samples)
        p = diastolic_mmHg + scale * (p - from);
    return { std::move(samples), period,
        "three-element windkessel, R 1 mmHg s/ml, C 1.5 ml/mmHg, Zc 0.05 mmHg s/ml (doi 10.1007/s11517-008-0359-2)" };
}

PulsePressure PulsePressure::constant(double mmHg)
{
    if (!std::isfinite(mmHg))
        throw InputError("the pressure must be finite", "pressure");
    return { { mmHg }, 1.0, "constant" };
}

PulsePressure PulsePressure::read_csv(const std::filesystem::path& file, double heart_rate_per_min)
{
    const std::vector<CsvRow> rows = read_rows(file);
    constexpr double kClosesWithin = 1.0; // mmHg; the tolerance allows for measured beats
    if (!(std::abs(rows.back().pressure - rows.front().pressure) <= kClosesWithin))
        throw InputError("the last line must close the beat: its pressure is that of the first", file.string());
    const double recorded = rows.back().time - rows.front().time;
    std::vector<double> samples(kSamples);
    std::size_t after = 1;
    for (std::size_t i = 0; i < kSamples; ++i) {
        const double t = rows.front().time + recorded * static_cast<double>(i) / static_cast<double>(kSamples);
        while (rows[after].time < t)
            ++after;
        const CsvRow &a = rows[after - 1], &b = rows[after];
        samples[i] = a.pressure + (b.pressure - a.pressure) * (t - a.time) / (b.time - a.time);
    }
    return { std::move(samples), heart_rate_per_min == 0.0 ? recorded : period_of(heart_rate_per_min),
        file.filename().string() };
}

double PulsePressure::at(double time_s) const noexcept
{
    const double beats = time_s / period_s_;
    const auto count = static_cast<double>(samples_.size());
    const double place = (beats - std::floor(beats)) * count;
    const auto first = std::min(static_cast<std::size_t>(place), samples_.size() - 1);
    const std::size_t second = first + 1 < samples_.size() ? first + 1 : 0;
    return samples_[first] + (samples_[second] - samples_[first]) * (place - static_cast<double>(first));
}

double PulsePressure::rate_for(double heart_rate_per_min) const { return period_s_ / period_of(heart_rate_per_min); }

double PulsePressure::lowest_mmHg() const { return *std::min_element(samples_.begin(), samples_.end()) / kMPaPerMmHg; }
double PulsePressure::highest_mmHg() const { return *std::max_element(samples_.begin(), samples_.end()) / kMPaPerMmHg; }

} // namespace retractor::haptics
