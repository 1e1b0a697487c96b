#include "ui/workstation/planning/session_model.h"

#include "mesh/base/error.h"
#include "ui/workstation/planning/metric_rows.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <string>

namespace retractor::ui {
namespace session_model_test {

    constexpr double kRounding = 16.0 * std::numeric_limits<double>::epsilon(); // a few operations on unit vectors

    planner::Approach straight_approach(const std::string& name)
    {
        planner::Approach approach;
        approach.name = name;
        approach.template_name = "points";
        approach.incision = { { -30.0, 0.0, 0.0 }, { 10.0, 0.0, 0.0 }, { 30.0, 0.0, 0.0 } };
        approach.directions.assign(3, Vec3::UnitY());
        approach.depth_mm = 25.0;
        approach.target = { .label = "target" };
        return approach;
    }

    planner::Case three_approaches()
    {
        planner::Case planned_case;
        planned_case.label_table = { { 1, "target", "vessel", mesh::Role::target } };
        for (const char* name : { "median", "lateral", "distal" })
            planned_case.approaches.push_back(straight_approach(name));
        return planned_case;
    }

    FieldPictures field_of(const std::string& name)
    {
        FieldPictures field;
        field.metrics.name = name;
        field.surgeon.title = name + " surgeon";
        field.overview.title = name + " overview";
        return field;
    }

    /// The approach whose closed picture is to be made now; empty: none.
    std::string closed_name(SessionModel& model)
    {
        const std::optional<ClosedWork> work = model.begin_closed();
        return work && work->approach ? work->approach->name : std::string();
    }

    ClosedPictures titled(const std::string& title)
    {
        ClosedPictures pictures;
        pictures.patient.title = title;
        return pictures;
    }

    ClosedPictures with_slices(ClosedPictures pictures)
    {
        auto image = std::make_shared<mesh::Volume>();
        image->grid.size = { 10, 20, 30 };
        image->voxels.assign(image->grid.voxel_count(), 40);
        for (const auto& [plane, title] : { std::pair { SlicePlane::axial, "axial" },
                 std::pair { SlicePlane::coronal, "coronal" }, std::pair { SlicePlane::sagittal, "sagittal" } }) {
            Scene scene;
            scene.title = title;
            scene.slices.push_back({ .image = image, .plane = plane, .point = Vec3(3.0, 4.0, 5.0) });
            pictures.slices.push_back(std::move(scene));
        }
        return pictures;
    }

    TEST(SessionModel, SelectsTheFirstApproachAndAnyByName)
    {
        SessionModel model(three_approaches());
        EXPECT_EQ(model.selected(), 0U);
        model.select("distal");
        EXPECT_EQ(model.selected(), 2U);
    }

    TEST(SessionModel, ACaseWithoutApproachesShowsThePatientAlone)
    {
        SessionModel model { planner::Case {} };
        EXPECT_FALSE(model.selected());
        EXPECT_TRUE(model.shown_scenes().empty());
        EXPECT_FALSE(model.begin_plan());
        EXPECT_FALSE(model.view_available(ViewPreset::surgeon));
        const std::optional<ClosedWork> work = model.begin_closed();
        ASSERT_TRUE(work);
        EXPECT_FALSE(work->approach);
        model.closed_done(titled("patient"));
        EXPECT_FALSE(model.begin_closed());
        EXPECT_EQ(model.shown_view(), ViewPreset::overview);
        ASSERT_EQ(model.shown_scenes().size(), 1U);
        EXPECT_EQ(model.shown_scenes()[0].title, "patient");
    }

    TEST(SessionModel, EditsAreTakenBackAndMadeAgainWithTheirPlans)
    {
        SessionModel model(three_approaches());
        model.request_plan(1);
        model.begin_plan();
        model.plan_done(field_of("lateral"));
        EXPECT_FALSE(model.edit_to_undo());
        model.add_approach(straight_approach("mine"));
        EXPECT_EQ(model.selected(), 3U);
        EXPECT_EQ(model.edit_to_undo(), "add mine");
        planner::Approach longer = straight_approach("lateral");
        longer.incision.back().x() = 50.0;
        model.replace_approach(1, longer, "move lateral");
        EXPECT_EQ(model.selected(), 1U);
        EXPECT_EQ(model.approach(1).incision.back().x(), 50.0);
        EXPECT_EQ(model.approach(3).name, "mine") << "the others stay in their order";
        EXPECT_EQ(model.state(1).status, FieldStatus::closed) << "the plan was of the old incision";
        model.remove_approach(0);
        EXPECT_EQ(model.approach_count(), 3U);
        model.undo_edit();
        EXPECT_EQ(model.approach(0).name, "median");
        model.undo_edit();
        EXPECT_EQ(model.approach(1).incision.back().x(), 30.0);
        EXPECT_EQ(model.state(1).status, FieldStatus::planned) << "the plan of this incision is still right";
        model.undo_edit();
        EXPECT_EQ(model.approach_count(), 3U);
        EXPECT_FALSE(model.edit_to_undo());
        EXPECT_EQ(model.edit_to_redo(), "add mine");
        model.redo_edit();
        EXPECT_EQ(model.approach(3).name, "mine");
        model.remove_approach(3); // another future
        EXPECT_FALSE(model.edit_to_redo());
    }

    TEST(SessionModel, ARenamedApproachKeepsItsPlan)
    {
        SessionModel model(three_approaches());
        model.select(1);
        model.request_plan(1);
        model.begin_plan();
        FieldPictures field = field_of("lateral");
        field.surgeon.title = "lateral: through the incision";
        model.plan_done(field);
        const ShownSource before = model.shown_source();
        const auto title = [&] { return model.shown_scenes().back().title; };
        model.rename_approach(1, "Long one");
        EXPECT_EQ(model.approach(1).name, "lateral") << "files and decisions are found by it";
        EXPECT_EQ(model.state(1).status, FieldStatus::planned);
        EXPECT_FALSE(model.shown_source() == before) << "the picture bears the name";
        EXPECT_EQ(title(), "Long one: through the incision");
        Scene by_hand { .title = "lateral: by hand" };
        model.put_present_name(by_hand);
        EXPECT_EQ(by_hand.title, "Long one: by hand") << "the knife's picture";
        EXPECT_EQ(model.edit_to_undo(), "rename lateral");
        model.undo_edit();
        EXPECT_EQ(title(), "lateral: through the incision");
        model.redo_edit();
        EXPECT_EQ(title(), "Long one: through the incision");
        for (const char* taken : { "Long one", "median" })
            EXPECT_THROW(model.rename_approach(2, taken), InputError) << taken;
        for (const char* unreadable : { "two\nlines", "  " })
            EXPECT_THROW(model.rename_approach(2, unreadable), InputError);
        EXPECT_EQ(model.edit_to_undo(), "rename lateral");
        model.rename_approach(1, "");
        EXPECT_EQ(title(), "lateral: through the incision");
    }

    TEST(SessionModel, ARefusedEditChangesNothing)
    {
        SessionModel model(three_approaches());
        EXPECT_THROW(model.add_approach(straight_approach("median")), InputError) << "the name is taken";
        EXPECT_THROW(model.replace_approach(0, straight_approach("distal"), "rename"), InputError);
        EXPECT_EQ(model.approach_count(), 3U);
        EXPECT_EQ(model.approach(0).name, "median");
        EXPECT_FALSE(model.edit_to_undo());
    }

    TEST(SessionModel, APlanOfWhatWasRemovedOrChangedIsWithdrawn)
    {
        SessionModel model(three_approaches());
        model.request_plan(0);
        model.request_plan(2);
        EXPECT_EQ(model.begin_plan(), 0U);
        model.remove_approach(0);
        EXPECT_TRUE(model.busy());
        EXPECT_FALSE(model.planning()) << "it is in the list no more";
        EXPECT_TRUE(model.planning_unwanted());
        model.plan_cancelled();
        EXPECT_EQ(model.begin_plan(), 1U) << "the other request stands, at its new place";
        model.plan_done(field_of("distal"));
        EXPECT_EQ(model.state(1).status, FieldStatus::planned);
        model.undo_edit();
        EXPECT_EQ(model.state(0).status, FieldStatus::closed);
        EXPECT_EQ(model.state(2).status, FieldStatus::planned);
    }

    TEST(SessionModel, RefusesAnUnknownNameAndKeepsTheSelection)
    {
        SessionModel model(three_approaches());
        model.select(1);
        try {
            model.select("mediann");
            FAIL() << "an unknown approach was selected";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("lateral"), std::string::npos) << error.what();
        }
        EXPECT_EQ(model.selected(), 1U);
    }

    TEST(CaseFailure, AlwaysNamesTheFile)
    {
        const std::filesystem::path file = "patient/case.json";
        EXPECT_EQ(to_string(case_failure(file, InputError("is negative", "/approaches/0/depth_mm"))),
            "patient/case.json: /approaches/0/depth_mm: is negative");
        EXPECT_EQ(to_string(case_failure(file, IoError("cannot be read", "patient/case.json"))),
            "patient/case.json: cannot be read");
        EXPECT_EQ(to_string(case_failure(file, InputError("is empty"))), "patient/case.json: is empty");
    }

    TEST(Failure, NamesTheControlsOfTheFields)
    {
        EXPECT_EQ(with_controls({ "has no voxel", "structure aorta", { "structure" } }).what,
            "has no voxel (see File: Palpate a structure…)");
        EXPECT_EQ(with_controls({ "is too deep", "depth", { "depth_mm" } }).what, "is too deep") << "it has no control";
    }

    TEST(SessionModel, ClosedPicturesAreMadeOnceEachTheSelectedFirst)
    {
        SessionModel model(three_approaches());
        model.select(1);
        EXPECT_EQ(closed_name(model), "lateral");
        EXPECT_FALSE(model.begin_closed()) << "one at a time";
        model.closed_done(titled("lateral"));
        EXPECT_EQ(closed_name(model), "distal");
        model.select(0);
        model.closed_failed({ "no such voxel", "bone" });
        EXPECT_EQ(closed_name(model), "median");
        model.closed_done(titled("median"));
        EXPECT_FALSE(model.begin_closed()) << "a failed picture is not tried for ever";
        EXPECT_EQ(to_string(*model.state(2).failure), "bone: no such voxel");
    }

    TEST(SessionModel, PlansInTheOrderAskedOneAtATime)
    {
        SessionModel model(three_approaches());
        model.request_plan(2);
        model.request_plan(0);
        model.request_plan(2); // again: no second request
        EXPECT_EQ(model.begin_plan(), 2U);
        EXPECT_FALSE(model.begin_plan());
        EXPECT_EQ(model.state(2).status, FieldStatus::planning);
        EXPECT_EQ(model.state(0).status, FieldStatus::waiting);
        model.plan_done(field_of("distal"));
        EXPECT_EQ(model.state(2).status, FieldStatus::planned);
        EXPECT_EQ(model.begin_plan(), 0U);
        model.plan_done(field_of("median"));
        EXPECT_FALSE(model.begin_plan());
        EXPECT_FALSE(model.busy());
    }

    TEST(SessionModel, APlannedFieldIsKeptAndNotPlannedAgain)
    {
        SessionModel model(three_approaches());
        model.request_plan(0);
        model.begin_plan();
        model.plan_done(field_of("median"));
        const auto kept = model.state(0).field;
        model.select(1);
        model.select(0);
        model.request_plan(0);
        EXPECT_FALSE(model.begin_plan());
        EXPECT_EQ(model.state(0).field, kept);
    }

    TEST(SessionModel, APlanTakesThePlaceOfADraftAndNoDraftThatOfAPlan)
    {
        SessionModel model(three_approaches());
        model.request_plan(0, true);
        EXPECT_FALSE(model.can_plan(0)) << "it waits";
        model.begin_plan();
        EXPECT_TRUE(model.state(0).as_draft);
        model.plan_done(field_of("median"));
        EXPECT_FALSE(model.can_plan(0, true)) << "there is a draft";
        EXPECT_TRUE(model.planned().empty()) << "it is compared with nothing";
        model.request_plan(0, true);
        EXPECT_NE(model.state(0).field, nullptr);
        EXPECT_TRUE(model.can_plan(0));
        model.request_plan(0);
        EXPECT_EQ(model.state(0).field, nullptr) << "the draft's numbers are gone";
        EXPECT_EQ(model.begin_plan(), 0U);
        EXPECT_FALSE(model.state(0).as_draft);
        model.plan_done(field_of("median"));
        EXPECT_FALSE(model.can_plan(0, true));
        EXPECT_FALSE(model.can_plan(0));
    }

    TEST(SessionModel, CancelWithdrawsWaitingOnesAndStopsTheRunningOne)
    {
        SessionModel model(three_approaches());
        model.request_plan(0);
        model.request_plan(1);
        model.begin_plan();
        model.cancel();
        EXPECT_EQ(model.state(0).status, FieldStatus::cancelling);
        EXPECT_EQ(model.state(1).status, FieldStatus::closed);
        model.plan_cancelled();
        EXPECT_EQ(model.state(0).status, FieldStatus::closed);
        EXPECT_FALSE(model.begin_plan());
        model.request_plan(0); // it may be asked for again
        EXPECT_EQ(model.begin_plan(), 0U);
    }

    TEST(SessionModel, AResultThatOvertakesTheCancelIsKept)
    {
        SessionModel model(three_approaches());
        model.request_plan(0);
        model.begin_plan();
        model.cancel();
        model.plan_done(field_of("median"));
        EXPECT_EQ(model.state(0).status, FieldStatus::planned);
    }

    TEST(SessionModel, AFailedPlanKeepsItsReasonUntilItIsTriedAgain)
    {
        SessionModel model(three_approaches());
        model.request_plan(1);
        model.begin_plan();
        model.plan_failed({ "the blade does not meet the wall", "approach lateral" });
        EXPECT_EQ(model.state(1).status, FieldStatus::failed);
        EXPECT_EQ(to_string(*model.state(1).failure), "approach lateral: the blade does not meet the wall");
        model.request_plan(1);
        EXPECT_EQ(model.state(1).status, FieldStatus::waiting);
        EXPECT_FALSE(model.state(1).failure);
    }

    TEST(SessionModel, ShowsTheClosedPatientFirstThenTheOpenedField)
    {
        SessionModel model(three_approaches());
        EXPECT_TRUE(model.shown_scenes().empty());
        model.begin_closed();
        model.closed_done(with_slices(titled("closed")));
        ASSERT_EQ(model.shown_scenes().size(), 1U);
        EXPECT_EQ(model.shown_scenes()[0].title, "closed");
        EXPECT_TRUE(model.view_available(ViewPreset::slices));
        model.set_view(ViewPreset::slices);
        ASSERT_EQ(model.shown_scenes().size(), 4U);
        EXPECT_EQ(model.shown_scenes()[3].title, "closed");
        const ShownSource before = model.shown_source();
        model.set_slice_point(Vec3(3.0, 4.0, 9.0));
        EXPECT_EQ(model.shown_scenes()[0].slices.front().point.z(), 9.0);
        EXPECT_EQ(model.shown_scenes()[0].slices.front().window_hu, 500.0);
        model.set_grey_window(1);
        EXPECT_EQ(model.shown_scenes()[2].slices.front().level_hu, -600.0);
        EXPECT_EQ(model.shown_source(), before) << "the view moves the slices it shows";
        model.set_view(ViewPreset::surgeon);

        model.request_plan(0);
        model.begin_plan();
        model.plan_done(field_of("median"));
        EXPECT_EQ(model.shown_scenes().at(0).title, "median surgeon");
        model.set_view(ViewPreset::overview);
        EXPECT_EQ(model.shown_scenes().at(0).title, "median overview");
        model.set_view(ViewPreset::slices);
        ASSERT_EQ(model.shown_scenes().size(), 4U);
        EXPECT_EQ(model.shown_scenes()[0].title, "axial");
        EXPECT_EQ(model.shown_scenes()[3].title, "median overview");
        model.set_view(ViewPreset::surgeon);
        model.set_show_opened(false);
        EXPECT_EQ(model.shown_scenes().at(0).title, "closed");
    }

    TEST(SessionModel, TheIncisionIsShownInItsSlicesFromOutsideAndThroughIt)
    {
        SessionModel model(three_approaches());
        model.begin_closed();
        ClosedPictures pictures = with_slices(titled("closed"));
        EXPECT_FALSE(model.view_available(ViewPreset::incision));
        pictures.incision_slices = { pictures.slices[0], pictures.slices[1] };
        model.closed_done(std::move(pictures));
        ASSERT_TRUE(model.view_available(ViewPreset::incision));
        model.set_view(ViewPreset::incision);
        model.set_grey_window(2);
        const std::vector<Scene> scenes = model.shown_scenes();
        ASSERT_EQ(scenes.size(), 4U);
        EXPECT_EQ(scenes[0].slices.front().level_hu, 400.0);
        EXPECT_EQ(scenes[2].title, "closed");
        EXPECT_NE(scenes[2].camera.eye, scenes[3].camera.eye);
    }

    TEST(SessionModel, WhatIsPickedHasTheNamesOfSurgeons)
    {
        const SessionModel model(planner::Case {});
        EXPECT_EQ(model.name_of({ .name = "rib_left_4" }), "rib 4 on the left");
        EXPECT_EQ(model.name_of({ .name = "rib_right_11 (estimated)" }), "rib 11 on the right (estimated)");
        EXPECT_EQ(model.name_of({ .name = "pulmonary_trunk" }), "pulmonary trunk");
        EXPECT_EQ(model.name_of({ .name = "body" }), "skin");
    }

    TEST(Measurement, AnAreaIsThatOfItsPolygon)
    {
        // An L of 20 x 20 mm without its quarter, in a plane in no direction of the axes.
        const Vec3 u = Vec3(1.0, 2.0, 2.0) / 3.0, v = Vec3(2.0, 1.0, -2.0) / 3.0, from(5.0, -7.0, 11.0);
        Measurement area { .area = true };
        for (const auto& [x, y] : { std::pair { 0, 0 }, { 20, 0 }, { 20, 10 }, { 10, 10 }, { 10, 20 }, { 0, 20 } })
            area.places.push_back(from + x * u + y * v);
        EXPECT_NEAR(polygon_area_mm2(area.places), 300.0, 1e-9);
        EXPECT_EQ(measurement_text(area), "3.0 cm\u00b2 (perimeter 80 mm)");
        std::reverse(area.places.begin(), area.places.end());
        EXPECT_NEAR(polygon_area_mm2(area.places), 300.0, 1e-9) << "in either direction";
        area.places.resize(2);
        EXPECT_EQ(measurement_text(area), "") << "two corners";
        std::vector<Scene> scenes(1);
        area.places.push_back(from + 20.0 * v);
        draw_measurements(scenes, { area });
        EXPECT_EQ(scenes[0].lines.at(0).points.size(), 4U) << "closed";
    }

    TEST(SessionModel, MeasurementsLieInTheirPlanesAndAreTakenBackByPlaces)
    {
        SessionModel model(three_approaches());
        model.begin_closed();
        model.closed_done(with_slices(titled("closed")));
        model.set_view(ViewPreset::slices);
        EXPECT_EQ(model.measure({ 3.0, 4.0, 5.0 }), "");
        EXPECT_EQ(model.measure({ 6.0, 8.0, 5.0 }), "5.0 mm");
        const auto words_of = [&](std::size_t scene) { return model.shown_scenes()[scene].words.size(); };
        EXPECT_EQ(words_of(0), 1U) << "axial, through z = 5";
        EXPECT_EQ(words_of(1), 0U) << "the coronal slice holds only one of the places";
        EXPECT_EQ(words_of(3), 1U) << "in space";
        model.set_slice_point(Vec3(3.0, 4.0, 9.0));
        EXPECT_EQ(words_of(0), 0U) << "another plane";
        EXPECT_EQ(model.measure({ 10.0, 5.0, 5.0 }), "90\u00b0 (5.0 and 5.0 mm)");
        EXPECT_EQ(model.measure({ 1.0, 1.0, 1.0 }), "") << "another measurement";
        for (int n = 0; n < 4; ++n)
            EXPECT_TRUE(model.unmeasure());
        EXPECT_FALSE(model.unmeasure());
        EXPECT_FALSE(model.has_measurements());
        EXPECT_EQ(words_of(3), 0U);
        model.measure({ 3.0, 4.0, 5.0 });
        model.measure({ 6.0, 8.0, 5.0 });
        model.end_measurement();
        model.measure({ 1.0, 1.0, 1.0 });
        model.end_measurement(); // a single place gives no number
        EXPECT_EQ(words_of(3), 1U) << "the distance";
        model.forget_measurements();
        EXPECT_FALSE(model.has_measurements());
        EXPECT_EQ(words_of(3), 0U);
    }

    TEST(SessionModel, WhatIsShownChangesOnlyWhenThePictureDoes)
    {
        SessionModel model(three_approaches());
        model.begin_closed();
        model.closed_done(titled("closed"));
        const ShownSource first = model.shown_source();
        model.request_plan(1);
        model.begin_plan();
        model.plan_done(field_of("lateral"));
        EXPECT_EQ(model.shown_source(), first) << "another approach was planned";
        model.set_view(ViewPreset::overview);
        EXPECT_NE(model.shown_source(), first);
        model.set_view(ViewPreset::surgeon);
        EXPECT_EQ(model.shown_source(), first);
        model.request_plan(0);
        model.begin_plan();
        model.plan_done(field_of("median"));
        EXPECT_NE(model.shown_source(), first);
        model.set_show_opened(false);
        EXPECT_EQ(model.shown_source(), first);
    }

    TEST(SessionModel, APatientWithoutACtHasNoSlices)
    {
        SessionModel model(three_approaches());
        model.begin_closed();
        model.closed_done(titled("closed"));
        model.request_plan(0);
        model.begin_plan();
        model.plan_done(field_of("median"));
        EXPECT_FALSE(model.view_available(ViewPreset::slices));
        EXPECT_TRUE(model.view_available(ViewPreset::overview));
    }

    TEST(SurgeonCamera, LooksAlongTheBladeAtTheMiddleOfTheIncision)
    {
        const planner::Approach approach = straight_approach("median");
        const Camera camera = surgeon_camera(approach, Vec3::UnitZ());
        EXPECT_NEAR((camera.aim - Vec3::Zero()).norm(), 0.0, kRounding * 100.0);
        EXPECT_NEAR((camera.eye - Vec3(0.0, -approach.view.eye_distance_mm, 0.0)).norm(), 0.0, kRounding * 400.0);
        EXPECT_NEAR((camera.up - Vec3::UnitZ()).norm(), 0.0, kRounding);
        // An incision of 60 mm: the picture is 120 mm high where the skin is.
        const double height = 2.0 * 400.0 * std::tan(camera.view_angle_deg * std::numbers::pi / 360.0);
        EXPECT_NEAR(height, 120.0, kRounding * 1000.0);
    }

    TEST(SurgeonCamera, UpIsSquareToTheSightEvenWhenAskedAlongIt)
    {
        for (const Vec3& up : { Vec3(0.0, 1.0, 0.0), Vec3(0.3, 0.8, -0.2), Vec3(0.0, -5.0, 1e-3) }) {
            const Camera camera = surgeon_camera(straight_approach("median"), up);
            EXPECT_NEAR(camera.up.norm(), 1.0, kRounding);
            EXPECT_NEAR(camera.up.dot(Vec3::UnitY()), 0.0, kRounding);
        }
    }

    TEST(ViewPreset, IsReadByItsName)
    {
        EXPECT_EQ(view_from_string("surgeon"), ViewPreset::surgeon);
        EXPECT_EQ(view_from_string("overview"), ViewPreset::overview);
        EXPECT_EQ(view_from_string("slices"), ViewPreset::slices);
        EXPECT_FALSE(view_from_string("Surgeon"));
    }

    const MetricRow& row_of(const std::vector<MetricSection>& sections, const std::string& key)
    {
        for (const MetricSection& section : sections)
            for (const MetricRow& row : section.rows)
                if (row.key == key)
                    return row;
        throw std::out_of_range(key);
    }

    TEST(MetricRows, SayTheNumbersWithTheirUnits)
    {
        planner::FieldMetrics field;
        field.seen_best_eye = 0.6234;
        field.opening_area_mm2 = 4210.0;
        field.hook_force_N = 41.26;
        field.hooks = { { .name = "left 1", .side = 1, .force_N = 20.0 } };
        field.mechanics_status = "converged";
        const auto sections = field_rows(field);
        EXPECT_EQ(row_of(sections, "Target seen, best eye").value, "62.3 %");
        EXPECT_EQ(row_of(sections, "Opening area").value, "42.1 cm²");
        EXPECT_EQ(row_of(sections, "Force, larger side").value, "41.3 N");
        EXPECT_EQ(row_of(sections, "Hook left 1").value, "20.0 N");
        EXPECT_EQ(field_summary(field), "62 % seen, 41 N, 42 cm²");
        planner::FieldMetrics impossible = field;
        impossible.hook_force_N = 9727.0;
        EXPECT_EQ(field_summary(impossible), "Not usable");
        field.opening_width_mm = 57.9;
        planner::ErrorBars& bars = field.error.emplace();
        bars.opening_width_mm = 1.24;
        bars.seen_best_eye = 0.0234;
        bars.hook_force_N = 10.5;
        bars.hook_forces_N = { 5.25 };
        const auto estimated = field_rows(field);
        EXPECT_EQ(row_of(estimated, "Target seen, best eye").value, "62.3 ± 2.3 %");
        EXPECT_EQ(row_of(estimated, "Opening width").value, "57.9 ± 1.2 mm");
        EXPECT_EQ(row_of(estimated, "Force, larger side").value, "41.3 ± 10.5 N");
        EXPECT_EQ(row_of(estimated, "Hook left 1").value, "20.0 ± 5.2 N");
        bars.message = "not known";
        EXPECT_EQ(row_of(field_rows(field), "Opening width").value, "57.9 mm");
    }

    TEST(MetricRows, SayHowFarTissueIsStretchedAndTheLipsFollow)
    {
        planner::FieldMetrics field;
        EXPECT_THROW((void)row_of(field_rows(field), "Strain of skin"), std::out_of_range);
        field.tissue_strain = { { "skin", 0.5, Vec3::Zero(), "38 mm along the incision" },
            { "muscle", 0.4, Vec3::Zero(), "12 mm along the incision" } };
        field.lip_deviation = { { .side = -1, .largest_mm = 4.5, .mean_mm = 1.5 } };
        const auto sections = field_rows(field);
        EXPECT_EQ(row_of(sections, "Strain of skin").value, "50 %");
        EXPECT_TRUE(row_of(sections, "Strain of skin").warning);
        EXPECT_FALSE(row_of(sections, "Strain of muscle").warning) << "there is no published limit";
        EXPECT_EQ(row_of(sections, "Tearing").value, "possible");
        EXPECT_EQ(row_of(sections, "Off its line: right lip").value, "4.5 mm");
        field.tissue_strain.front().strain = 0.8;
        EXPECT_EQ(row_of(field_rows(field), "Tearing").value, "expected");
        field.tissue_strain.front().strain = 0.3;
        EXPECT_THROW((void)row_of(field_rows(field), "Tearing"), std::out_of_range);
    }

    TEST(MetricRows, SayTheAskedAndTheReachedAccuracy)
    {
        planner::FieldMetrics field;
        EXPECT_THROW((void)row_of(field_rows(field), "Accuracy of the force"), std::out_of_range);
        field.accuracy = planner::AccuracyMetrics { .asked = { .force = 0.15 },
            .reached_force = 0.22,
            .reached_opening_mm = 1.24,
            .rounds = 2,
            .edge_mm = 6.4,
            .ended_by = planner::AccuracyEnd::time };
        const auto sections = field_rows(field);
        EXPECT_EQ(row_of(sections, "Asked accuracy of the force").value, "15.0 %");
        EXPECT_EQ(row_of(sections, "Accuracy of the force").value, "22.0 %");
        EXPECT_TRUE(row_of(sections, "Accuracy of the force").warning);
        EXPECT_EQ(row_of(sections, "Accuracy of the opening").value, "1.2 mm");
        EXPECT_EQ(row_of(sections, "Finest edges tried").value, "6.4 mm");
        field.accuracy->ended_by = planner::AccuracyEnd::reached;
        EXPECT_FALSE(row_of(field_rows(field), "Accuracy of the force").warning);
    }

    TEST(MetricRows, WarnWhereSurfacesPassThroughEachOther)
    {
        planner::FieldMetrics field;
        EXPECT_THROW((void)row_of(field_rows(field), "Contact"), std::out_of_range);
        field.contact = planner::ContactMetrics { .needed = false, .computed = false };
        EXPECT_EQ(row_of(field_rows(field), "Contact").value, "nothing touches");
        EXPECT_FALSE(row_of(field_rows(field), "Contact").warning);
        field.contact = planner::ContactMetrics { .needed = true, .touching = 23 };
        EXPECT_EQ(row_of(field_rows(field), "Contact").value, "23 points touch");
        field.contact = planner::ContactMetrics {
            .needed = true, .computed = false, .largest_penetration_mm = 3.24, .with = "heart", .message = "why"
        };
        EXPECT_EQ(row_of(field_rows(field), "Contact").value, "3.2 mm passed through");
        EXPECT_TRUE(row_of(field_rows(field), "Contact").warning);
    }

    TEST(MetricRows, NameTheMomentOfTheForce)
    {
        planner::FieldMetrics field;
        field.hook_force_N = 260.0;
        EXPECT_THROW((void)row_of(field_rows(field), "... at the last turn"), std::out_of_range);
        field.force_moments = planner::ForceMoments { .peak_N = 260.0,
            .held_N = 49.4,
            .held_least_N = 25.8,
            .held_most_N = 73.0,
            .opened_in_s = 80.0,
            .hold_s = 300.0,
            .protocol = "half a turn of the crank (7 mm) every 10 s",
            .source = "a paper" };
        const auto sections = field_rows(field);
        EXPECT_EQ(row_of(sections, "... at the last turn").value, "260 N");
        EXPECT_FALSE(row_of(sections, "... at the last turn").warning);
        EXPECT_EQ(row_of(sections, "... after 5 minutes").value, "about 49 N");
        EXPECT_NE(row_of(sections, "... after 5 minutes").meaning.find("26 to 73 N"), std::string::npos);
        field.force_moments->is_fast = true;
        EXPECT_TRUE(row_of(field_rows(field), "Speed of opening").warning);
        field.force_moments->message = "hook left pulls with a given force";
        EXPECT_EQ(row_of(field_rows(field), "... after minutes").value, "not applicable");
    }

    TEST(MetricRows, SayWhatTheWoundGapesByAndWhatPresses)
    {
        planner::FieldMetrics field;
        field.tension.emplace().gape_mm = 8.04;
        EXPECT_EQ(row_of(field_rows(field), "Gape without hooks").value, "8.0 mm");
        field.pressures = { { .label = "lung_left", .pressure_kPa = 1.333 } };
        const auto pressed = field_rows(field);
        EXPECT_EQ(row_of(pressed, "Gape under pressure, without hooks").value, "8.0 mm");
        EXPECT_THROW((void)row_of(pressed, "Gape without hooks"), std::out_of_range);
        EXPECT_EQ(row_of(pressed, "Pressure").value, "1.33 kPa");
        EXPECT_NE(row_of(pressed, "Pressure").meaning.find("left lung"), std::string::npos);
        field.tension->message = "the wall was not solved";
        EXPECT_EQ(row_of(field_rows(field), "Gape under pressure, without hooks").value, "unknown");
    }

    TEST(MetricRows, WarnWhenTheModelIsInDoubt)
    {
        planner::FieldMetrics field;
        field.mechanics_status = "converged";
        EXPECT_FALSE(row_of(field_rows(field), "Equilibrium").warning);
        EXPECT_FALSE(row_of(field_rows(field), "Inverted").warning);
        field.mechanics_status = "not converged";
        field.inverted_elements = 3;
        field.max_volume_ratio = 2.5;
        EXPECT_TRUE(row_of(field_rows(field), "Equilibrium").warning);
        EXPECT_TRUE(row_of(field_rows(field), "Inverted").warning);
        EXPECT_TRUE(row_of(field_rows(field), "Largest volume ratio").warning);
        field.volume_failures = planner::VolumeFailures {};
        EXPECT_FALSE(row_of(field_rows(field), "Soft tissue off its volume").warning);
        field.volume_failures->believable = false;
        EXPECT_TRUE(row_of(field_rows(field), "Soft tissue off its volume").warning);
        field.implausible = { "the depth of the cut is 0.04 mm" };
        EXPECT_TRUE(row_of(field_rows(field), "Implausible").warning);
    }

    TEST(MetricRows, WarnOfAFractureAndOfferTheOpeningWithoutOne)
    {
        planner::FieldMetrics field;
        field.attainable = planner::Attainable::yes;
        EXPECT_FALSE(row_of(field_rows(field), "Opening possible").warning);
        EXPECT_THROW((void)row_of(field_rows(field), "Without a fracture"), std::out_of_range);
        field.attainable = planner::Attainable::with_injury;
        field.largest_uninjured_opening_mm = 27.4;
        field.bones = { { .name = "rib_left_5",
            .part = "lateral",
            .moment_Nm = 3.4,
            .capacity_Nm = 2.9,
            .utilisation = 1.172,
            .opening_at_limit_mm = 27.4 } };
        const auto sections = field_rows(field);
        EXPECT_EQ(row_of(sections, "Opening possible").value, "with injury: rib 5 on the left");
        EXPECT_TRUE(row_of(sections, "Opening possible").warning);
        EXPECT_NE(row_of(sections, "Opening possible").meaning.find("would break"), std::string::npos);
        EXPECT_EQ(row_of(sections, "Without a fracture").value, "about 27 mm");
        EXPECT_EQ(row_of(sections, "Most loaded rib").value, "117.2 %");
    }

    TEST(MetricRows, AnUnplannedApproachSaysWhatWasAskedFor)
    {
        planner::Approach approach = straight_approach("median");
        approach.hooks = { { .name = "left 1", .side = 1, .opening_mm = 30.0 } };
        EXPECT_EQ(row_of(approach_rows(approach), "Incision length").value, "60 mm");
        EXPECT_EQ(row_of(approach_rows(approach), "Hook left 1").value, "30 mm");
        EXPECT_EQ(approach_summary(approach), "60 mm long, 1 hook");
        approach.opening_protocol = planner::OpeningProtocol { .wait_s = 30.0 };
        EXPECT_EQ(row_of(approach_rows(approach), "Opened by").value, "half a turn of the crank (7 mm) every 30 s");
    }

    TEST(MetricRows, AHookIsShownByWhatDrivesIt)
    {
        planner::Approach approach = straight_approach("median");
        approach.hooks = { { .name = "pulls", .pull = { .force_N = 25.0 } },
            { .name = "yields", .opening_mm = 30.0, .pull = { .force_limit_N = 40.0, .grip_N_per_mm = 2.5 } } };
        const std::vector<MetricSection> rows = approach_rows(approach);
        EXPECT_EQ(row_of(rows, "Hook pulls").value, "25.0 N");
        EXPECT_NE(row_of(rows, "Hook pulls").meaning.find("force"), std::string::npos);
        EXPECT_EQ(row_of(rows, "Hook yields").value, "30 mm, at most 40.0 N, grip 2.5 N/mm");
        EXPECT_NE(row_of(rows, "Hook yields").meaning.find("yields"), std::string::npos);
    }

    TEST(SessionModel, MapsColourOpenedFieldsAndNothingElse)
    {
        SessionModel model(three_approaches());
        model.request_plan(0);
        ASSERT_TRUE(model.begin_plan());
        FieldPictures field = field_of("median");
        field.maps[FieldMapKind::strain].legend = { { "strain", "" } };
        field.maps[FieldMapKind::eyes] = { .legend = { { "eyes", "" } }, .from_side_deg = 50.0 };
        model.plan_done(field);
        model.set_view(ViewPreset::surgeon);
        EXPECT_TRUE(model.map_available(FieldMapKind::strain));
        EXPECT_FALSE(model.map_available(FieldMapKind::pressure));
        const ShownSource plain = model.shown_source();
        EXPECT_TRUE(model.shown_scenes().front().legend.empty());
        model.set_map(FieldMapKind::strain);
        EXPECT_NE(model.shown_source(), plain) << "it is drawn anew";
        EXPECT_EQ(model.shown_scenes().front().legend.front().key, "strain");
        model.set_map(FieldMapKind::pressure); // the field has none
        EXPECT_TRUE(model.shown_scenes().front().legend.empty());
        model.set_map(FieldMapKind::eyes); // from outside only
        EXPECT_TRUE(model.shown_scenes().front().legend.empty());
        model.set_view(ViewPreset::overview);
        EXPECT_EQ(model.shown_scenes().front().legend.front().key, "eyes");
        model.select(1); // not planned
        EXPECT_FALSE(model.map_available(FieldMapKind::strain));
    }

} // namespace session_model_test
} // namespace retractor::ui
