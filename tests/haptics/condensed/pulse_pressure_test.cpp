#include "haptics/condensed/pulse_pressure.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

namespace retractor::haptics {
namespace pulse_pressure_test {

    constexpr double kRoundOff = 1e-12;

    std::filesystem::path written(const char* name, const char* text)
    {
        const std::filesystem::path file = std::filesystem::path(testing::TempDir()) / name;
        std::ofstream(file) << text;
        return file;
    }

    TEST(PulsePressure, AorticCurveIsPeriodicBetweenItsBounds)
    {
        const PulsePressure pulse = PulsePressure::aortic(75.0);
        EXPECT_DOUBLE_EQ(pulse.period_s(), 0.8);
        EXPECT_NEAR(pulse.lowest_mmHg(), 80.0, 1e-9);
        EXPECT_NEAR(pulse.highest_mmHg(), 120.0, 1e-9);
        for (const double t : { 0.0, 0.123, 0.4, 0.79999 }) {
            EXPECT_NEAR(pulse.at(t), pulse.at(t + 8.0), kRoundOff);
            EXPECT_NEAR(pulse.at(t), pulse.at(t - 0.8), kRoundOff);
        }
    }

    TEST(PulsePressure, AorticCurveHasSystoleNotchAndDecay)
    {
        // At 75 beats per minute ejection ends at 0.30 s, the valve closes by 0.34 s, then the windkessel empties with
        // its time constant R C = 1.5 s towards zero pressure (before the curve is scaled: so only the shape is known).
        const PulsePressure pulse = PulsePressure::aortic(75.0);
        double peak = 0.0, when = 0.0;
        for (int i = 0; i < 800; ++i)
            if (const double p = pulse.at(i * 1e-3); p > peak) {
                peak = p;
                when = i * 1e-3;
            }
        EXPECT_GT(when, 0.10);
        EXPECT_LT(when, 0.30);
        EXPECT_LT(pulse.at(0.32), pulse.at(0.345)); // the notch
        for (double t = 0.36; t < 0.79; t += 0.01)
            EXPECT_GT(pulse.at(t), pulse.at(t + 0.01)) << t;
    }

    TEST(PulsePressure, MillimetresOfMercuryAreConvertedAtTheBorder)
    {
        EXPECT_NEAR(PulsePressure::constant(40.0).at(3.0), 16.0 / 3.0 * 1e-3, 1e-6); // 40 mmHg, as in the tube problem
    }

    TEST(PulsePressure, CsvIsReadAndStretchedToTheHeartRate)
    {
        const auto file = written("beat.csv", "# one beat\ntime_s,pressure_mmHg\n0,80\n0.25,120\n0.5,100\n1.0,80\n");
        const PulsePressure as_is = PulsePressure::read_csv(file);
        EXPECT_DOUBLE_EQ(as_is.period_s(), 1.0);
        constexpr double kSampling = 0.2; // mmHg: 512 samples a beat, linear between them
        EXPECT_NEAR(as_is.at(0.125) / kMPaPerMmHg, 100.0, kSampling);
        EXPECT_NEAR(as_is.at(0.75) / kMPaPerMmHg, 90.0, kSampling);
        const PulsePressure faster = PulsePressure::read_csv(file, 120.0);
        EXPECT_DOUBLE_EQ(faster.period_s(), 0.5);
        EXPECT_NEAR(faster.at(0.375), as_is.at(0.75), kRoundOff);
    }

    void expect_refused(const char* text, const std::string& what, const std::string& where)
    {
        const auto file = written("bad.csv", text);
        try {
            PulsePressure::read_csv(file);
            FAIL() << text;
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find(what), std::string::npos) << error.what();
            EXPECT_NE(error.where().find(where), std::string::npos) << error.where();
        }
    }

    TEST(PulsePressure, BadFilesAreRefusedByLine)
    {
        expect_refused("0,80\n1,80\n", "begins with", "line 1");
        expect_refused("time_s,pressure_mmHg\n0,80\n0.5,nan\n1,80\n", "finite", "line 3");
        expect_refused("time_s,pressure_mmHg\n0,80\n0.5,100\n0.5,90\n1,80\n", "rise", "line 4");
        expect_refused("time_s,pressure_mmHg\n0,80\n0.5,100;3\n1,80\n", "two finite numbers", "line 3");
        expect_refused("time_s,pressure_mmHg\n0,80\n0.5,120\n1,100\n", "close the beat", "bad.csv");
        expect_refused("time_s,pressure_mmHg\n0,80\n", "three lines", "bad.csv");
        EXPECT_THROW(PulsePressure::read_csv("no/such/file.csv"), IoError);
        EXPECT_THROW(PulsePressure::aortic(5.0), InputError);
        EXPECT_THROW(PulsePressure::aortic(75.0, 120.0, 80.0), InputError);
        EXPECT_THROW(PulsePressure::constant(std::nan("")), InputError);
    }

    TEST(BeatClock, IsTheClockUntilToldAndThenGoesOnWithoutAJump)
    {
        BeatClock clock;
        for (const double t : { 0.0, 0.001, 0.3, 7.7 })
            EXPECT_EQ(clock.at(t), t);
        const PulsePressure pulse = PulsePressure::aortic(60.0);
        clock.set_rate(pulse.rate_for(120.0));
        EXPECT_EQ(clock.at(8.0), 8.0) << "from here on";
        EXPECT_NEAR(clock.at(8.5), 9.0, kRoundOff);
        clock.set_rate(0.5);
        EXPECT_NEAR(clock.at(9.0), 10.0, kRoundOff);
        EXPECT_NEAR(clock.at(11.0), 11.0, kRoundOff);
        EXPECT_THROW((void)pulse.rate_for(10.0), InputError);
    }

} // namespace pulse_pressure_test
} // namespace retractor::haptics
