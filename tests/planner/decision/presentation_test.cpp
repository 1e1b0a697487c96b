#include "planner/decision/presentation.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace retractor::planner {
namespace presentation_test {

    Case two_approaches()
    {
        Case planned_case;
        for (const char* name : { "median", "lateral" }) {
            Approach approach;
            approach.name = name;
            approach.template_name = "points";
            approach.incision = { { 0, 0, 50 }, { 0, 0, -50 } };
            approach.directions.assign(2, Vec3::UnitY());
            approach.depth_mm = 30.0;
            approach.target.label = "aneurysm";
            planned_case.approaches.push_back(approach);
        }
        return planned_case;
    }

    FieldMetrics field_of(const std::string& name, double seen)
    {
        FieldMetrics field;
        field.name = name;
        field.target = "aneurysm";
        field.target_spec.label = "aneurysm";
        field.seen_best_eye = seen;
        field.reached_by_two_instruments = 0.4;
        field.finger_lacks_mm = 12.0;
        field.mechanics_status = "converged";
        return field;
    }

    std::vector<PresentedView> views_of(const std::vector<PresentationStep>& steps)
    {
        std::vector<PresentedView> views;
        for (const PresentationStep& step : steps)
            views.push_back(step.view);
        return views;
    }

    TEST(Presentation, GoesFromTheIncisionToWhatIsSeenAndComparesAtTheEnd)
    {
        const FieldMetrics median = field_of("median", 0.6), lateral = field_of("lateral", 0.1);
        const auto steps = presentation_of(two_approaches(),
            { { .field = &median, .has_slices = true, .divided_bones = { "sternum" } },
                { .field = &lateral, .has_slices = false } },
            {});
        EXPECT_EQ(views_of(steps),
            (std::vector { PresentedView::incision, PresentedView::blade, PresentedView::cut, PresentedView::opened,
                PresentedView::seen, PresentedView::reached, PresentedView::incision, PresentedView::cut,
                PresentedView::opened, PresentedView::seen, PresentedView::reached, PresentedView::comparison }));
        for (const PresentationStep& step : steps)
            EXPECT_FALSE(step.text.empty()) << step.title;
        EXPECT_EQ(steps[0].text, "The incision is 100 mm long. The target: aneurysm.");
        EXPECT_NE(steps[4].text.find("60 %"), std::string::npos) << steps[4].text;
        EXPECT_EQ(steps[1].text, "The blade goes 30 mm deep.");
        EXPECT_EQ(steps[2].text, "The red sheet is the cut. Sawn through: sternum.");
        EXPECT_EQ(steps[0].approach, 0U);
        EXPECT_EQ(steps[5].text,
            "Two instruments reach 40 % of what an eye could see of the aneurysm. A finger ends 12 mm "
            "before the aneurysm.");
        EXPECT_EQ(steps[6].approach, 1U);
        EXPECT_EQ(steps.back().compared, (std::vector<std::size_t> { 0, 1 }));
        EXPECT_NE(steps.back().text.find("Nothing is chosen yet."), std::string::npos);
        EXPECT_NE(steps.back().text.find(" A: "), std::string::npos) << "what speaks against each: " << steps.back().text;
        EXPECT_NE(steps.back().text.find(" B: "), std::string::npos) << steps.back().text;
    }

    TEST(Presentation, OneOrNoPlanIsNotCompared)
    {
        const FieldMetrics median = field_of("median", 0.6);
        EXPECT_EQ(views_of(presentation_of(two_approaches(), { { .field = &median }, {} }, {})),
            (std::vector { PresentedView::incision, PresentedView::cut, PresentedView::opened, PresentedView::seen,
                PresentedView::reached, PresentedView::incision, PresentedView::cut }));
        EXPECT_EQ(views_of(presentation_of({}, {}, {})), (std::vector { PresentedView::patient }));
    }

    TEST(Presentation, WhatIsComparedIsTheTeamsChoice)
    {
        Case planned_case = two_approaches();
        planned_case.approaches.push_back(planned_case.approaches.front());
        planned_case.approaches.back().name = "midcab";
        const FieldMetrics median = field_of("median", 0.6), lateral = field_of("lateral", 0.1),
                           midcab = field_of("midcab", 0.3);
        Decisions decisions;
        decisions.compared = { "midcab", "lateral" };
        const auto steps = presentation_of(
            planned_case, { { .field = &median }, { .field = &lateral }, { .field = &midcab } }, decisions);
        EXPECT_EQ(steps.back().compared, (std::vector<std::size_t> { 1, 2 }));
        EXPECT_NE(steps.back().text.find("Not shown here: median."), std::string::npos) << steps.back().text;
    }

    TEST(Presentation, NamedViewsFollowTheirApproach)
    {
        const FieldMetrics median = field_of("median", 0.6);
        Decisions decisions;
        decisions.views
            = { { .name = "close", .approach = "median" }, { .name = "before", .approach = "lateral", .opened = false },
                  { .name = "open", .approach = "lateral" }, { .name = "gone", .approach = "removed" } };
        const auto steps = presentation_of(two_approaches(), { { .field = &median }, {} }, decisions);
        // "open" of the lateral approach waits for its plan.
        ASSERT_EQ(views_of(steps),
            (std::vector { PresentedView::incision, PresentedView::cut, PresentedView::opened, PresentedView::seen,
                PresentedView::reached, PresentedView::kept, PresentedView::incision, PresentedView::cut,
                PresentedView::kept }));
        EXPECT_EQ(steps[5].kept->name, "close");
        EXPECT_NE(steps[8].title.find("before"), std::string::npos);
    }

} // namespace presentation_test
} // namespace retractor::planner
