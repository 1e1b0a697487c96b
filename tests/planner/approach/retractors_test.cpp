#include "planner/approach/retractors.h"

#include "mesh/base/error.h"
#include "planner/approach/hooks.h"
#include "planner/case/case_io.h"
#include "tests/support/block_case.h"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <numbers>
#include <string>
#include <vector>

namespace retractor::planner {
namespace retractors_test {

    constexpr double kRoundOff = 1e-12;

    /// 100 mm along y on the plane z = 0, straight down, through a wall of 30 mm.
    Approach straight()
    {
        Approach approach;
        approach.name = "straight";
        approach.incision = { Vec3(0.0, 0.0, 0.0), Vec3(0.0, 100.0, 0.0) };
        approach.directions = { Vec3(0.0, 0.0, -1.0), Vec3(0.0, 0.0, -1.0) };
        approach.wall_thickness_mm = { 30.0, 30.0 };
        approach.hook_depth_mm = { 18.0, 18.0 };
        approach.depth_mm = 35.0;
        approach.target.radius_mm = 10.0;
        return approach;
    }

    Approach with_retractor(const std::string& kind, const RetractorDrive& drive)
    {
        Approach approach = straight();
        approach.retractor = make_retractor(approach, find_retractor(built_in_retractors(), kind), drive);
        return approach;
    }

    std::string refusal(const Approach& approach)
    {
        try {
            check_approach(approach);
        } catch (const InputError& error) {
            return std::string(error.where()) + ": " + error.what();
        }
        return "taken";
    }

    std::filesystem::path written(const std::string& name, const std::string& text)
    {
        std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / name;
        std::ofstream(file) << text;
        return file;
    }

    TEST(Retractors, EveryKindOfTheTableFitsItsOwnLimits)
    {
        for (const RetractorKind& kind : built_in_retractors()) {
            Approach approach = straight();
            approach.retractor = make_retractor(approach, kind, { .opening_mm = 50.0 });
            EXPECT_NO_THROW(check_approach(approach)) << kind.kind;
            EXPECT_FALSE(kind.source.empty()) << kind.kind;
            EXPECT_FALSE(kind.meaning.empty()) << kind.kind;
        }
    }

    TEST(Retractors, HaveTheNamesThatSurgeonsUse)
    {
        EXPECT_EQ(instrument_name("finochietto"), "Finochietto rib spreader");
        EXPECT_EQ(instrument_name("sternal"), "sternal spreader");
        EXPECT_EQ(instrument_name("midcab"), "MIDCAB retractor");
        EXPECT_EQ(instrument_name("small"), "small retractor") << "of the user's own table";
        EXPECT_EQ(instrument_name("small spreader"), "small spreader");
    }

    TEST(Retractors, BladesFaceEachOtherInTheMiddleAndHangFromTheirArms)
    {
        Approach approach = with_retractor("finochietto", { .opening_mm = 60.0 });
        approach.hooks = blades_of(approach);
        ASSERT_EQ(approach.hooks.size(), 2U);
        for (const HookSpec& blade : approach.hooks) {
            EXPECT_NEAR(blade.along_mm, 50.0, kRoundOff);
            EXPECT_EQ(blade.opening_mm, 30.0);
            EXPECT_EQ(blade.patch_width_mm, approach.retractor->blade_width_mm);
            EXPECT_NEAR(blade.patch_height_mm, 26.0, kRoundOff); // the wall of 30 mm, without 2 mm at either side
            EXPECT_LT((blade.direction - Vec3(-blade.side, 0.0, 0.0)).norm(), kRoundOff);
        }
        const fem::BladeFrame frame = blade_frame_of(approach);
        EXPECT_NO_THROW(fem::check_frame(frame));
        for (const fem::FrameBlade& blade : frame) {
            EXPECT_LT((blade.pivot - Vec3(0.0, 50.0, 0.0)).norm(), kRoundOff); // on the skin
            EXPECT_LT((blade.arm - Vec3::UnitY()).norm(), kRoundOff);
            EXPECT_NEAR(blade.play, approach.retractor->play_deg * std::numbers::pi / 180.0, kRoundOff);
        }
    }

    TEST(Retractors, AThickWallGetsDeeperBladesOfTheSameKind)
    {
        const RetractorKind& sternal = find_retractor(built_in_retractors(), "sternal");
        Approach approach = straight();
        const auto depth_of = [&](double wall_mm) {
            approach.wall_thickness_mm = { 20.0, wall_mm };
            approach.depth_mm = wall_mm + 5.0;
            return make_retractor(approach, sternal, { .opening_mm = 50.0 }).blade_depth_mm;
        };
        EXPECT_EQ(depth_of(25.0), sternal.blade_depth_mm);
        // The blades are 90 mm wide on 100 mm: at their ends the wall is 95 % of the way to its thickest.
        EXPECT_NEAR(depth_of(60.0), 20.0 + 0.95 * 40.0, kRoundOff);
        EXPECT_EQ(depth_of(120.0), sternal.deepest_blade_mm);
        // Where the cut ends within the wall, nothing is known of the wall's other side.
        approach.wall_thickness_mm = { 20.0, 60.0 };
        approach.depth_mm = 40.0;
        EXPECT_NEAR(make_retractor(approach, sternal, {}).blade_depth_mm, 35.0, kRoundOff);
        approach.wall_thickness_mm = { 60.0, 60.0 };
        EXPECT_NEAR(make_retractor(approach, sternal, {}).blade_depth_mm, 40.0, kRoundOff) << "as deep as the cut";
    }

    TEST(Retractors, OneThatIsMovedToAThickerWallGetsDeeperBlades)
    {
        Approach approach = with_retractor("midcab", { .opening_mm = 20.0 });
        const double usual = approach.retractor->blade_depth_mm;
        deepen_blades(approach);
        EXPECT_EQ(approach.retractor->blade_depth_mm, usual);
        approach.wall_thickness_mm = { 60.0, 60.0 };
        approach.depth_mm = 70.0;
        EXPECT_NEAR(with_retractor_at(approach, *approach.retractor, Vec3(0.0, 50.0, 0.0)).retractor->blade_depth_mm,
            60.0, kRoundOff);
        approach.retractor->kind = "mine";
        deepen_blades(approach);
        EXPECT_EQ(approach.retractor->blade_depth_mm, usual) << "how deep its blades are made is not known";
    }

    TEST(Retractors, AShortBladeHoldsTheTissueBelowTheSkin)
    {
        Approach approach = with_retractor("midcab", { .opening_mm = 20.0 });
        approach.retractor->blade_depth_mm = 12.0;
        for (const HookSpec& blade : blades_of(approach)) {
            EXPECT_NEAR(blade.patch_height_mm, 10.0, kRoundOff);
            EXPECT_NEAR(blade.depth_mm + 0.5 * blade.patch_height_mm, 12.0, kRoundOff);
        }
    }

    TEST(Retractors, BadOnesAreRefusedWithTheirPlace)
    {
        Approach both = with_retractor("sternal", { .opening_mm = 60.0 });
        both.hooks = blades_of(both);
        EXPECT_NE(refusal(both).find("either hooks or a retractor"), std::string::npos);
        EXPECT_NE(
            refusal(with_retractor("midcab", { .opening_mm = 95.0 })).find("opens at most 90 mm"), std::string::npos);
        EXPECT_NE(
            refusal(with_retractor("finochietto", { .opening_mm = 180.0 })).find("tears before"), std::string::npos);
        EXPECT_NE(refusal(with_retractor("sternal", { .opening_mm = 10.0, .force_N = 10.0 })).find("not both"),
            std::string::npos);
        EXPECT_NE(
            refusal(with_retractor("sternal", { .force_N = -1.0 })).find("/retractor/force_N"), std::string::npos);
        Approach wide = with_retractor("sternal", { .opening_mm = 10.0 });
        wide.retractor->blade_width_mm = 120.0;
        EXPECT_NE(refusal(wide).find("does not fit"), std::string::npos);
        Approach loose = with_retractor("sternal", { .opening_mm = 10.0 });
        loose.retractor->play_deg = NAN;
        EXPECT_NE(refusal(loose).find("/retractor/play_deg"), std::string::npos);
        EXPECT_THROW((void)find_retractor(built_in_retractors(), "spoon"), InputError);
    }

    TEST(Retractors, ATableOfOnesOwnIsRead)
    {
        const std::string begin
            = R"({"kind": "mine", "meaning": "a spreader", "blade_width_mm": 40, "blade_depth_mm": 30, )";
        const std::string end = R"("play_deg": 5, "greatest_opening_mm": 120, "source": "measured"})";
        const std::string row = begin + end;
        const std::vector<RetractorKind> table
            = read_retractors(written("retractors.json", R"({"retractors": [)" + row + "]}"));
        ASSERT_EQ(table.size(), 1U);
        EXPECT_EQ(table[0].kind, "mine");
        EXPECT_EQ(table[0].play_deg, 5.0);
        EXPECT_EQ(table[0].deepest_blade_mm, 30.0); // all of its blades have one depth
        const auto with_deepest = [&](const char* depth) {
            return read_retractors(written(
                "deep.json", R"({"retractors": [)" + begin + R"("deepest_blade_mm": )" + depth + ", " + end + "]}"));
        };
        EXPECT_EQ(with_deepest("60").at(0).deepest_blade_mm, 60.0);
        EXPECT_THROW((void)with_deepest("20"), InputError);
        EXPECT_THROW(
            (void)read_retractors(written("twice.json", R"({"retractors": [)" + row + "," + row + "]}")), InputError);
        EXPECT_THROW((void)read_retractors(written("none.json", R"({"retractors": []})")), InputError);
        EXPECT_THROW((void)read_retractors(written("short.json", R"({"retractors": [{"kind": "mine"}]})")), InputError);
        EXPECT_THROW((void)read_retractors("/nowhere/retractors.json"), IoError);
    }

    TEST(Retractors, OneThatWasCrankedByHandJoinsTheApproachWhereItLies)
    {
        const Approach approach = straight();
        RetractorSpec cranked
            = make_retractor(approach, find_retractor(built_in_retractors(), "midcab"), { .opening_mm = 24.0 });
        const Approach with = with_retractor_at(approach, cranked, Vec3(5.0, 40.0, -8.0));
        ASSERT_TRUE(with.retractor.has_value());
        EXPECT_NEAR(with.retractor->along_mm, 40.0, kRoundOff);
        EXPECT_EQ(with.retractor->opening_mm, 24.0);
        // Near an end the blade stays within the wound.
        EXPECT_NEAR(with_retractor_at(approach, cranked, Vec3(0.0, 99.0, 0.0)).retractor->along_mm, 85.0, kRoundOff);
        EXPECT_THROW((void)with_retractor_at(approach, cranked, Vec3(40.0, 50.0, 0.0)), InputError);
        cranked.opening_mm = 500.0;
        EXPECT_THROW((void)with_retractor_at(approach, cranked, Vec3(0.0, 50.0, 0.0)), InputError);
    }

    TEST(Retractors, ACaseKeepsItsRetractor)
    {
        const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
        Case planned_case = test_support::block_case("retractor_io", phantom);
        Approach approach = straight();
        add_approach(planned_case, approach);
        set_retractor(
            planned_case, approach.name, find_retractor(built_in_retractors(), "midcab"), { .force_N = 12.0 });
        write_case(planned_case);
        const Case read = read_case(planned_case.file());
        const Approach& again = find_approach(read, approach.name);
        ASSERT_TRUE(again.retractor.has_value());
        EXPECT_TRUE(again.hooks.empty());
        EXPECT_EQ(again.retractor->kind, "midcab");
        EXPECT_EQ(again.retractor->force_N, 12.0);
        EXPECT_EQ(again.retractor->opening_mm, 0.0);
        EXPECT_EQ(again.retractor->blade_width_mm, 30.0);
        EXPECT_EQ(again.retractor->hold, HookHold::contact); // where the file says nothing, as here
        EXPECT_EQ(blades_of(again)[0].hold, HookHold::contact);
    }

    TEST(Retractors, ACaseKeepsHowBladesAndHooksHold)
    {
        const datasets::Phantom phantom = datasets::make_block_phantom(test_support::small_block());
        Case planned_case = test_support::block_case("retractor_hold", phantom);
        Approach with_retractor = straight(), with_hooks = straight();
        with_hooks.name = "hooks";
        with_hooks.hooks = make_hooks(with_hooks, "2", 10.0);
        EXPECT_EQ(with_hooks.hooks[0].hold, HookHold::fixed);
        with_hooks.hooks[1].hold = HookHold::contact;
        add_approach(planned_case, with_retractor);
        add_approach(planned_case, with_hooks);
        set_retractor(
            planned_case, with_retractor.name, find_retractor(built_in_retractors(), "midcab"), { .opening_mm = 12.0 });
        find_approach(planned_case, with_retractor.name).retractor->hold = HookHold::fixed;
        const std::string text = case_to_json(planned_case);
        const Case read = case_from_json(text, planned_case.folder);
        EXPECT_EQ(find_approach(read, with_retractor.name).retractor->hold, HookHold::fixed);
        EXPECT_EQ(blades_of(find_approach(read, with_retractor.name))[1].hold, HookHold::fixed);
        EXPECT_EQ(find_approach(read, "hooks").hooks[0].hold, HookHold::fixed);
        EXPECT_EQ(find_approach(read, "hooks").hooks[1].hold, HookHold::contact);
        std::string bad = text;
        bad.replace(bad.find("\"fixed\"", bad.find("\"retractor\":")), 7, "\"glued\"");
        try {
            (void)case_from_json(bad, planned_case.folder);
            FAIL() << "a hold that is not known must be refused";
        } catch (const InputError& error) {
            EXPECT_EQ(std::string(error.what()), "unknown \"glued\": use fixed or contact");
            EXPECT_NE(error.where().find("/retractor/hold"), std::string::npos) << error.where();
        }
    }

} // namespace retractors_test
} // namespace retractor::planner
