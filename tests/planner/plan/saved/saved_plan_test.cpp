#include "planner/plan/saved/saved_plan.h"

#include "mesh/base/error.h"
#include "planner/approach/retractors.h"
#include "planner/measures/metrics.h"
#include "planner/plan/plan.h"
#include "tests/support/block_case.h"
#include "tests/support/temporary_folder.h"

#include <Eigen/Geometry>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>

namespace retractor::planner {
namespace saved_plan_test {

    namespace fs = std::filesystem;

    struct Planned {
        Case planned_case;
        PlannedField field;
    };

    /// A block that a retractor opens.
    /// @param plans false: the field only looks as if it had been planned
    Planned plan_block(bool plans)
    {
        const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
        Case planned_case = test_support::block_case("saved_plan", phantom);
        planned_case.solution = { .elasticity = fem::Elasticity::linear };
        Approach approach;
        {
            Patient patient(planned_case, {});
            approach = test_support::block_approach(*patient.labels(), Eigen::Isometry3d::Identity(), 0.0);
        }
        approach.name = "straight";
        approach.hooks.clear();
        approach.sizing.region_mm = 30.0;
        RetractorKind kind = find_retractor(built_in_retractors(), "midcab");
        kind.blade_width_mm = 20.0;
        approach.retractor = make_retractor(approach, kind, { .opening_mm = 6.0 });
        approach.retractor->hold = HookHold::fixed;
        planned_case.approaches = { approach };
        if (!plans) {
            PlannedField field;
            field.approach = approach;
            field.metrics.name = approach.name;
            return { planned_case, field };
        }
        Patient patient(planned_case, {});
        return { planned_case, plan_approach(patient, approach, {}) };
    }

    /// A field that is made once for all tests; each test has a folder of its own.
    class SavedPlan : public testing::Test {
    protected:
        static const Planned& planned()
        {
            static const Planned made = plan_block(false);
            return made;
        }
        SavedPlan()
            : here(planned().planned_case)
        {
            here.folder = folder_.path;
        }
        fs::path file() const { return plan_file(here, "straight"); }
        std::string content() const
        {
            std::ifstream in(file(), std::ios::binary);
            return { std::istreambuf_iterator<char>(in), {} };
        }

        Case here;

    private:
        test_support::TemporaryFolder folder_;
    };

    TEST_F(SavedPlan, IsReadAsItWasPlanned)
    {
        Planned whole = plan_block(true);
        here.approaches = whole.planned_case.approaches;
        whole.field.best_eye.two_instruments_reach = { 2, 70'000 }; // nothing reaches into so small a wound
        whole.field.best_eye.finger_touches = { 5 };
        const PlannedField& field = whole.field;
        ASSERT_EQ(field.status, PlanStatus::done) << field.message;
        ASSERT_TRUE(field.metrics.error && field.metrics.retractor && field.metrics.parameters);
        save_plan(here, field);
        const auto saved = read_saved_plan(here, "straight");
        ASSERT_TRUE(saved);
        const PlannedField& read = saved->field;
        // Every number that people are told.
        EXPECT_EQ(metrics_document({ read.metrics }), metrics_document({ field.metrics }));
        EXPECT_EQ(read.status, field.status);
        EXPECT_EQ(read.message, field.message);
        EXPECT_EQ(read.approach.retractor->kind, "midcab");
        EXPECT_EQ(read.approach.hooks.size(), field.approach.hooks.size());
        ASSERT_EQ(read.hooks.size(), field.hooks.size());
        for (std::size_t h = 0; h < read.hooks.size(); ++h) {
            EXPECT_EQ(read.hooks[h].nodes, field.hooks[h].nodes);
            EXPECT_EQ(read.hooks[h].displacement, field.hooks[h].displacement);
            EXPECT_EQ(read.hooks[h].rotation, field.hooks[h].rotation);
        }
        EXPECT_EQ(read.wall.vertices, field.wall.vertices);
        EXPECT_EQ(read.wall.nodes, field.wall.nodes);
        EXPECT_EQ(read.wall.labels, field.wall.labels);
        EXPECT_EQ(read.opening.displacement, field.opening.displacement);
        EXPECT_EQ(read.opening.strain, field.opening.strain);
        EXPECT_EQ(read.geometry.centre, field.geometry.centre);
        EXPECT_EQ(read.best_eye.eye, field.best_eye.eye);
        EXPECT_EQ(read.best_eye.two_instruments_reach, field.best_eye.two_instruments_reach);
        EXPECT_EQ(read.best_eye.finger_touches, field.best_eye.finger_touches);
        EXPECT_EQ(read.remaining_wall.triangles, field.remaining_wall.triangles);
        EXPECT_EQ(saved->date.size(), std::string("2026-11-22T12:58:03Z").size());
    }

    TEST_F(SavedPlan, BelongsToWhatItWasMadeFrom)
    {
        EXPECT_FALSE(read_saved_plan(here, "straight")) << "there is none";
        save_plan(here, planned().field);
        const auto is_read = [&](const auto& change) {
            Case changed = here;
            change(changed);
            return read_saved_plan(changed, changed.approaches.front().name).has_value();
        };
        EXPECT_TRUE(is_read([](Case&) {}));
        EXPECT_TRUE(is_read([](Case& c) { c.views = { "overview" }; })) << "pictures are no input";
        EXPECT_TRUE(is_read([](Case& c) { c.sizing.region_mm = 60.0; })) << "of new approaches";
        EXPECT_TRUE(is_read([](Case& c) { c.patient = datasets::PatientIdentity { .name = "A^B", .id = {} }; }));
        EXPECT_TRUE(is_read([](Case& c) {
            Approach other = c.approaches.front();
            other.name = "other";
            c.approaches.push_back(other);
        }));
        EXPECT_TRUE(is_read([](Case& c) { c.approaches.front().title = "Long one"; })) << "no number depends on it";
        Case titled = here;
        titled.approaches.front().title = "Long one";
        EXPECT_EQ(read_saved_plan(titled, "straight")->field.approach.title, "Long one") << "as it is called now";
        EXPECT_FALSE(is_read([](Case& c) { c.approaches.front().retractor->opening_mm += 1.0; }));
        EXPECT_FALSE(is_read([](Case& c) { c.approaches.front().incision.front().z() += 1e-6; }));
        EXPECT_FALSE(is_read([](Case& c) { c.approaches.front().sizing.mesh_seed = 1; }));
        EXPECT_FALSE(is_read([](Case& c) { c.solution.elasticity = fem::Elasticity::corotational; }));
        EXPECT_FALSE(is_read([](Case& c) { c.materials.front().youngs_modulus_MPa *= 1.1; }));
        EXPECT_FALSE(is_read([](Case& c) { c.labels.sha256.front() = c.labels.sha256.front() == '0' ? '1' : '0'; }));
        EXPECT_FALSE(is_read([](Case& c) {
            c.assumed_vessels = { { .name = "mammary_artery_left", .line = { Vec3::Zero(), Vec3::UnitZ() } } };
        })) << "its distances are numbers of the plan";
        EXPECT_FALSE(read_saved_plan(here, "nobody"));
    }

    TEST_F(SavedPlan, WhatIsTriedAndUndoneDoesNotCostThePlanBefore)
    {
        save_plan(here, planned().field);
        const double opening = here.approaches.front().retractor->opening_mm;
        const auto with_opening = [&](double more) {
            Case changed = here;
            changed.approaches.front().retractor->opening_mm = opening + more;
            return changed;
        };
        save_plan(with_opening(1.0), planned().field);
        EXPECT_TRUE(read_saved_plan(here, "straight"));
        EXPECT_TRUE(read_saved_plan(with_opening(1.0), "straight"));
        // Another approach whose name begins alike keeps its own.
        Case longer = here;
        longer.approaches.front().name = "straight-01234567";
        PlannedField renamed = planned().field;
        renamed.approach.name = longer.approaches.front().name;
        save_plan(longer, renamed);
        for (std::size_t n = 2; n < 2 + kKeptPlans; ++n)
            save_plan(with_opening(static_cast<double>(n)), planned().field);
        EXPECT_FALSE(read_saved_plan(here, "straight")) << "the oldest goes";
        EXPECT_TRUE(read_saved_plan(with_opening(1.0 + kKeptPlans), "straight"));
        EXPECT_TRUE(read_saved_plan(longer, longer.approaches.front().name));
        const auto files = std::distance(fs::directory_iterator(file().parent_path()), fs::directory_iterator());
        EXPECT_EQ(files, static_cast<std::ptrdiff_t>(kKeptPlans) + 1);
    }

    TEST_F(SavedPlan, HoldsNoIdentity)
    {
        here.patient = datasets::PatientIdentity { .name = "Family^Given", .id = {} };
        save_plan(here, planned().field);
        EXPECT_EQ(content().find("Family"), std::string::npos);
    }

    TEST_F(SavedPlan, DamageIsTold)
    {
        save_plan(here, planned().field);
        const std::string whole = content();
        const auto write = [&](const std::string& bytes) { std::ofstream(file(), std::ios::binary) << bytes; };
        for (const std::size_t at : { whole.find('\n') + 1, whole.size() / 3, whole.size() - 1 }) {
            std::string damaged = whole;
            damaged[at] = static_cast<char>(damaged[at] ^ 4);
            write(damaged);
            EXPECT_THROW(static_cast<void>(read_saved_plan(here, "straight")), InputError) << at;
        }
        for (const std::size_t size :
            { std::size_t { 0 }, std::size_t { 5 }, whole.find('\n') + 3, whole.size() - 1 }) {
            write(whole.substr(0, size));
            EXPECT_THROW(static_cast<void>(read_saved_plan(here, "straight")), InputError) << size;
        }
        write("retractor plan 0\n" + whole);
        EXPECT_FALSE(read_saved_plan(here, "straight")) << "of another version";
        write(whole);
        EXPECT_TRUE(read_saved_plan(here, "straight"));
    }

    TEST_F(SavedPlan, AFolderThatCannotBeMadeIsNamed)
    {
        std::ofstream(here.folder / "plans") << "a file";
        try {
            save_plan(here, planned().field);
            FAIL();
        } catch (const IoError& error) {
            EXPECT_NE(to_string(current_failure()).find("plans"), std::string::npos) << error.what();
        }
    }

} // namespace saved_plan_test
} // namespace retractor::planner
