// A palpation without a window: devices, tissue and servo together. Nothing here depends on how fast the machine is:
// what takes a moment is waited for.

#include "tests/planner/session/touchable_tube.h"

#include "haptics/recording/motion_file.h"
#include "mesh/base/error.h"
#include "planner/session/palpation_worker.h"

#include <gtest/gtest.h>

#include <chrono>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

namespace retractor::planner {
namespace palpation_session_test {

    namespace fs = std::filesystem;

    constexpr double kPatience = 60.0; // s, on a busy machine
    constexpr double kPressedN = 0.02; ///< far above rounding, far below what 1 mm takes

    template <class Call> std::string message_of(const Call& call)
    {
        try {
            call();
        } catch (const Error& error) {
            return std::string(error.what()) + " [" + error.where() + "]";
        }
        return {};
    }

    class PalpationSessionTest : public testing::Test {
    protected:
        void open(const PalpationSetup& setup = {}, std::vector<ThroughOpening> ways = {})
        {
            for (std::size_t f = 0; f < kMostFingers; ++f) {
                pointers_.push_back(std::make_unique<haptics::PointerDevice>(
                    haptics::PointerOptions { .workspace = { Vec3::Constant(-1000.0), Vec3::Constant(1000.0) } },
                    mouse_info(f)));
                raw_.push_back(pointers_.back().get());
                pointers_.back()->hop_to(Vec3::Constant(900.0));
            }
            PalpationBackend backend = tube_backend(control_);
            backend.ways = std::move(ways);
            session_ = std::make_unique<PalpationSession>(tube_scene(), setup, std::move(backend), raw_, Job {});
            session_->frame(frame_);
        }
        /// Frames until it is so.
        bool until(const std::function<bool()>& so)
        {
            const auto began = std::chrono::steady_clock::now();
            while (std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count() < kPatience) {
                session_->frame(frame_);
                if (so())
                    return true;
                std::this_thread::sleep_for(std::chrono::milliseconds(5));
            }
            return false;
        }
        double force(std::size_t finger = 0) const { return frame_.servo.contacts[finger].force.norm(); }
        void press(double depth)
        {
            const datasets::TouchSite& site = session_->scene().site("centre");
            pointers_[0]->hop_to(site.point + (4.0 - depth) * site.outward);
        }
        /// The force that a press comes to rest at.
        double settled_force()
        {
            constexpr double kApart = 0.1, kStill = 1e-6; // s of the servo's time; N
            double last = -1.0, since = frame_.servo.time_s;
            EXPECT_TRUE(until([&] {
                if (frame_.servo.time_s < since + kApart)
                    return false;
                const bool still = force() > kPressedN && std::abs(force() - last) < kStill;
                last = force();
                since = frame_.servo.time_s;
                return still;
            }));
            return force();
        }

        std::shared_ptr<TubeControl> control_ = std::make_shared<TubeControl>();
        std::vector<std::unique_ptr<haptics::PointerDevice>> pointers_;
        std::vector<haptics::PointerDevice*> raw_;
        PalpationFrame frame_;
        std::unique_ptr<PalpationSession> session_;
    };

    TEST_F(PalpationSessionTest, APressIsAForceAndADentAndReleaseIsNone)
    {
        open();
        ASSERT_TRUE(until([&] { return frame_.servo.ticks > 0; }));
        EXPECT_EQ(force(), 0.0);
        press(1.0);
        const double one = settled_force();
        const datasets::TouchSite& site = session_->scene().site("centre");
        const Eigen::VectorXd moved = (frame_.shown - frame_.surface->vertices) * site.outward;
        EXPECT_LT(moved.minCoeff(), -0.3) << "mm, inwards; a fingertip of 1 mm depth between coarse vertices";
        press(2.0);
        EXPECT_TRUE(until([&] { return force() > 1.5 * one; })) << "linear: twice the depth is about twice the force";
        EXPECT_EQ(frame_.strip.back().force[0], force());
        pointers_[0]->hop_to(Vec3::Constant(900.0));
        EXPECT_TRUE(until([&] { return force() == 0.0; }));
    }

    TEST_F(PalpationSessionTest, ThroughASlitAFingerTouchesWhatItReaches)
    {
        open();
        ASSERT_TRUE(until([&] { return frame_.servo.ticks > 0; }));
        press(1.0);
        const double without = settled_force();
        EXPECT_EQ(frame_.reached, nullptr) << "nothing is round it";
        session_.reset();
        pointers_.clear();
        raw_.clear();
        open({}, slit_before_tube(20.0));
        ASSERT_TRUE(until([&] { return frame_.servo.ticks > 0; }));
        ASSERT_NE(frame_.reached, nullptr);
        EXPECT_EQ(frame_.reached->size(), frame_.surface->triangles.size());
        EXPECT_GT(frame_.reached_share, 0.02) << "the near side";
        EXPECT_LT(frame_.reached_share, 0.3) << "not the far side";
        const Vec3 out = session_->scene().site("centre").outward;
        for (std::size_t t = 0; t < frame_.reached->size(); ++t) {
            const auto& corners = frame_.surface->triangles[t];
            const Vec3 a = frame_.surface->vertices.row(corners[0]), b = frame_.surface->vertices.row(corners[1]),
                       c = frame_.surface->vertices.row(corners[2]);
            if ((*frame_.reached)[t] != 0) {
                EXPECT_GT((b - a).cross(c - a).normalized().dot(out), 0.0) << "it faces the slit";
            }
        }
        press(1.0);
        constexpr double kBalance = 1e-3; // of the force; the same tissue under the same finger
        EXPECT_NEAR(settled_force(), without, kBalance * without);
        EXPECT_FALSE(frame_.servo.contacts[0].stopped);
        EXPECT_GT(frame_.servo.contacts[0].outward.dot(session_->scene().site("centre").outward), 0.8);
        // Under the lip, where no straight finger comes to, the hand is held back.
        const datasets::TouchSite& site = session_->scene().site("centre");
        pointers_[0]->hop_to(site.point - 20.0 * site.outward + 25.0 * tube_axis());
        EXPECT_TRUE(until([&] { return frame_.servo.contacts[0].stopped; }));
        EXPECT_NE(frame_.servo.contacts[0].stopped_by, haptics::DistanceGrid::kNone) << "and by something";
        const double of_finger = frame_.reached_share;
        PalpationSetup with_instrument = session_->setup();
        with_instrument.through = "instrument";
        session_->change(with_instrument, Job {});
        session_->frame(frame_);
        EXPECT_GT(frame_.reached_share, 1.3 * of_finger) << "half as thick, and longer";
    }

    TEST_F(PalpationSessionTest, AnEditIsFeltAndResetTakesItBack)
    {
        open();
        press(1.0);
        const double before = settled_force();
        const haptics::ElasticTemplate stiff {
            .centre = session_->scene().site("centre").point, .half_size = Vec3::Constant(100.0), .youngs_modulus = 4.0
        };
        EXPECT_EQ(session_->edit(stiff), session_->scene().body.mesh.tet_count());
        // Everything has four times the modulus, so everything takes four times the force.
        EXPECT_TRUE(until([&] { return !frame_.stiffness_pending && std::abs(force() / before - 4.0) < 1e-3; }))
            << force() << " after " << before;
        session_->reset(Job {});
        EXPECT_TRUE(until([&] { return std::abs(force() / before - 1.0) < 1e-3; })) << force() << " after " << before;
    }

    TEST_F(PalpationSessionTest, TheHeartBeatsAsToldAndNotWithoutPulse)
    {
        control_->pulse = true;
        open();
        EXPECT_TRUE(session_->abilities().pulse);
        session_->set_heart_rate(180.0);
        EXPECT_EQ(session_->heart_rate(), 180.0);
        double low = 1e9, high = 0.0;
        EXPECT_TRUE(until([&] {
            if (frame_.strip.empty())
                return false;
            low = std::min(low, frame_.strip.back().pressure_mmHg);
            high = std::max(high, frame_.strip.back().pressure_mmHg);
            return high - low > 30.0;
        }));
        EXPECT_NE(message_of([&] { session_->set_heart_rate(0.0); }).find("between 20 and 300"), std::string::npos);
        PalpationSetup setup = session_->setup();
        setup.model = "spheres";
        session_->change(setup, Job {});
        EXPECT_EQ(message_of([&] { session_->set_heart_rate(60.0); }), "this tissue has no pulse [vessel]");
        EXPECT_FALSE(session_->abilities().edits);
        EXPECT_EQ(session_->notes(), std::vector<std::string> { "a tube of spheres" });
        EXPECT_EQ(session_->finger_count(), kMostFingers);
        EXPECT_TRUE(until([&] { return frame_.spheres != nullptr && frame_.servo.finger_count == kMostFingers; }));
        EXPECT_EQ(frame_.sphere_centres.rows(), static_cast<Eigen::Index>(frame_.spheres->radius.size()));
    }

    TEST_F(PalpationSessionTest, ASimulatedHandPressesByItself)
    {
        open({ .devices = { "simulated:firm" }, .press_mm = 2.0 });
        EXPECT_TRUE(until([&] { return force() > kPressedN; }));
        EXPECT_TRUE(until([&] { return force() == 0.0; })) << "it lifts its finger again";
        EXPECT_EQ(force(1), 0.0) << "the second finger is the mouse's";
    }

    TEST_F(PalpationSessionTest, WhatCannotBeMadeLeavesEverythingAsItWas)
    {
        open();
        press(1.0);
        const double before = settled_force();
        PalpationSetup setup = session_->setup();
        setup.model = "springs";
        EXPECT_EQ(message_of([&] { session_->change(setup, Job {}); }), "springs do not hold this tube [springs]");
        EXPECT_EQ(session_->setup().model, "fem");
        setup = session_->setup();
        setup.devices = { "no such device" };
        EXPECT_NE(message_of([&] { session_->change(setup, Job {}); }).find("no such device"), std::string::npos);
        EXPECT_TRUE(session_->setup().devices.empty()) << "the mouse has it";
        setup = session_->setup();
        setup.force_gain = 0.0;
        EXPECT_NE(message_of([&] { session_->change(setup, Job {}); }).find("gain"), std::string::npos);
        const std::uint64_t ticks = frame_.health.ticks;
        EXPECT_TRUE(until([&] { return frame_.health.ticks > ticks + 10; })) << "the servo runs on";
        EXPECT_NEAR(settled_force(), before, 1e-3 * before);
    }

    TEST_F(PalpationSessionTest, TheGainIsTheHandsAndNotTheTissues)
    {
        open({ .force_gain = 3.0 });
        press(1.0);
        const double tripled = settled_force();
        PalpationSetup setup = session_->setup();
        setup.force_gain = 1.0;
        session_->change(setup, Job {});
        EXPECT_NEAR(settled_force(), tripled, 1e-3 * tripled) << "what is shown is the tissue's own force";
    }

    TEST_F(PalpationSessionTest, AFaultIsLatchedUntilItIsArmedAgain)
    {
        control_->can_be_sick = true;
        open();
        press(1.0);
        ASSERT_TRUE(until([&] { return force() > kPressedN && frame_.servo.force_share == 1.0; }));
        control_->sick = true;
        ASSERT_TRUE(until([&] { return frame_.servo.fault.kind == haptics::FaultKind::bad_force; }));
        control_->sick = false;
        EXPECT_TRUE(until([&] { return frame_.servo.force_share == 0.0; })) << "it stays away";
        session_->rearm();
        EXPECT_TRUE(until(
            [&] { return frame_.servo.fault.kind == haptics::FaultKind::none && frame_.servo.force_share == 1.0; }));
    }

    TEST_F(PalpationSessionTest, ARecordingBeginsAndEndsWhileTheServoRuns)
    {
        open();
        const auto second_is_there
            = [&] { return (frame_.servo.fingers[1].position - Vec3::Constant(900.0)).norm() < 1.0; };
        press(1.0);
        // Hops are nearly jumps: where a replay skips a tick they are, and the finger stays until it is armed again.
        ASSERT_TRUE(until([&] { return second_is_there() && force() > kPressedN; }));
        session_->start_recording();
        ASSERT_TRUE(session_->recording());
        EXPECT_NE(message_of([&] { session_->reset(Job {}); }).find("stop it first"), std::string::npos);
        EXPECT_TRUE(until([&] { return frame_.recorded_s > 0.05 && force() > kPressedN; }));
        std::size_t lost = 1;
        const haptics::MotionRecording recording = session_->stop_recording(lost);
        EXPECT_FALSE(session_->recording());
        EXPECT_EQ(lost, 0U);
        EXPECT_EQ(recording.devices.size(), 2U);
        ASSERT_GT(recording.tick_count(), 10U);
        EXPECT_GT(recording.at(recording.tick_count() - 1, 0).commanded_force.norm(), kPressedN);
        const fs::path file = fs::temp_directory_path() / "palpation_session_test.motion";
        haptics::write_motion(file, recording);
        EXPECT_EQ(haptics::read_motion(file).tick_count(), recording.tick_count());
        // The same motion again, in the scene's own frame: the same press.
        PalpationSetup setup = session_->setup();
        setup.devices = { "replay:" + file.string() };
        session_->change(setup, Job {});
        EXPECT_TRUE(until([&] { return force() > kPressedN; }));
        // The second finger plays the second device: that one touched nothing.
        setup.devices = { "mouse", "replay:" + file.string() };
        pointers_[0]->hop_to(Vec3::Constant(900.0));
        session_->change(setup, Job {});
        EXPECT_TRUE(until(second_is_there));
        EXPECT_EQ(force(1), 0.0);
        fs::remove(file);
    }

    bool wait_for(const PalpationWorker& worker, const std::function<bool(const PalpationSnapshot&)>& so)
    {
        const auto began = std::chrono::steady_clock::now();
        while (std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count() < kPatience) {
            if (so(*worker.snapshot()))
                return true;
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        }
        return false;
    }

    TEST_F(PalpationSessionTest, ARecordingIsKeptUntilItIsWritten)
    {
        PalpationWorker worker(tube_scene(), {}, tube_backend(control_));
        ASSERT_TRUE(wait_for(worker, [](const auto& now) { return now.phase == PalpationSnapshot::Phase::ready; }));
        worker.run(palpation::StartRecording {});
        const auto began = std::chrono::steady_clock::now();
        while (!(worker.has_frame() && worker.frame().recorded_s > 0.05)
            && std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count() < kPatience)
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        const fs::path file = fs::temp_directory_path() / "palpation_worker_test.motion";
        std::ofstream(file) << "no folder";
        worker.run(palpation::StopRecording { file / "motion" });
        ASSERT_TRUE(wait_for(worker, [](const auto& now) { return now.refused && now.unwritten_recording; }));
        worker.run(palpation::StartRecording {});
        EXPECT_TRUE(
            wait_for(worker, [](const auto& now) { return now.answer.find("not written yet") != std::string::npos; }));
        worker.run(palpation::StopRecording { file });
        EXPECT_TRUE(wait_for(worker, [](const auto& now) { return !now.refused && !now.unwritten_recording; }));
        EXPECT_GT(haptics::read_motion(file).tick_count(), 10U);
        fs::remove(file);
    }

    TEST_F(PalpationSessionTest, EditsGoWithTheirTissueAlsoWhenADeviceIsMissing)
    {
        PalpationWorker worker(tube_scene(), {}, tube_backend(control_));
        ASSERT_TRUE(wait_for(worker, [](const auto& now) { return now.phase == PalpationSnapshot::Phase::ready; }));
        worker.run(palpation::EditTissue { { .centre = tube_scene().site("centre").point, .youngs_modulus = 2.0 } });
        EXPECT_TRUE(wait_for(worker, [](const auto& now) { return now.edits.size() == 1; }));
        worker.run(palpation::ChangeSetup { { .model = "spheres", .devices = { "no such device" } } });
        EXPECT_TRUE(wait_for(worker, [](const auto& now) { return now.refused && now.setup.model == "spheres"; }));
        EXPECT_TRUE(worker.snapshot()->edits.empty());
    }

    TEST_F(PalpationSessionTest, OnlyTheEditThatCannotBeIsTakenBack)
    {
        PalpationWorker worker(tube_scene(), {}, tube_backend(control_));
        ASSERT_TRUE(wait_for(worker, [](const auto& now) { return now.phase == PalpationSnapshot::Phase::ready; }));
        const Vec3 centre = tube_scene().site("centre").point;
        worker.run(palpation::EditTissue {
            { .centre = centre, .half_size = Vec3::Constant(1e3), .role = datasets::VertexRole::fixed } });
        worker.run(palpation::EditTissue { { .centre = centre, .youngs_modulus = 2.0 } });
        worker.run(palpation::EditTissue { { .centre = centre, .youngs_modulus = 3.0 } });
        const auto refusal = [](const auto& now) { return now.refused && now.edits.size() == 2; };
        ASSERT_TRUE(wait_for(worker, refusal)) << worker.snapshot()->edits.size();
        EXPECT_EQ(worker.snapshot()->edits[0].youngs_modulus, 2.0);
        EXPECT_EQ(worker.snapshot()->edits[1].youngs_modulus, 3.0);
    }

    TEST_F(PalpationSessionTest, AWorkerSaysWhatItCannotDo)
    {
        PalpationWorker worker(tube_scene(), {}, tube_backend(control_));
        const auto wait = [&](const std::function<bool(const PalpationSnapshot&)>& so) { return wait_for(worker, so); };
        ASSERT_TRUE(wait([](const auto& now) { return now.phase == PalpationSnapshot::Phase::ready; }));
        worker.run(palpation::EditTissue { { .centre = Vec3::Constant(500.0), .youngs_modulus = 2.0 } });
        EXPECT_TRUE(wait([](const auto& now) { return now.refused && now.answers == 1; }));
        EXPECT_NE(worker.snapshot()->answer.find("nothing lies inside"), std::string::npos);
        EXPECT_TRUE(worker.snapshot()->edits.empty());
        worker.run(palpation::EditTissue { { .centre = tube_scene().site("centre").point, .youngs_modulus = 2.0 } });
        EXPECT_TRUE(wait([](const auto& now) { return !now.refused && now.edits.size() == 1; }));
        worker.run(palpation::SetHeartRate { 60.0 }); // the tube's scene has a pulse, whatever its pressure does here
        EXPECT_TRUE(wait([](const auto& now) { return now.heart_rate == 60.0; }));
        PalpationWorker none(tube_scene(), { .model = "springs" }, tube_backend(control_));
        const auto began = std::chrono::steady_clock::now();
        while (none.snapshot()->phase == PalpationSnapshot::Phase::preparing
            && std::chrono::duration<double>(std::chrono::steady_clock::now() - began).count() < kPatience)
            std::this_thread::sleep_for(std::chrono::milliseconds(5));
        EXPECT_EQ(none.snapshot()->failure, "springs: springs do not hold this tube");
    }

} // namespace palpation_session_test
} // namespace retractor::planner
