#include "planner/measures/report/report.h"

#include "mesh/base/error.h"
#include "planner/measures/metrics.h"
#include "planner/measures/verdict.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>

namespace retractor::planner {
namespace report_test {

    namespace fs = std::filesystem;

    FieldMetrics sample_field(const std::string& name)
    {
        FieldMetrics m;
        m.name = name;
        m.target = "aneurysm";
        m.seen_best_eye = 0.25;
        m.mechanics_status = "converged";
        m.hooks = { { "left 1", 1, 10.0 }, { "left 2", 1, 12.5 }, { "right 1", -1, 7.0 } };
        m.hook_force_N = 22.5;
        m.bone_in_sight = { "rib_left_4" };
        m.seconds = { { "mesh", 1.5 }, { "cut", 0.25 } };
        return m;
    }

    void add_bars(FieldMetrics& field, double opening_mm, double force_N, double share = 0.0)
    {
        field.opening_width_mm = 40.0;
        ErrorBars& error = field.error.emplace();
        error.opening_width_mm = opening_mm;
        error.seen_best_eye = share;
        error.hook_force_N = force_N;
        error.hook_forces_N.assign(field.hooks.size(), force_N);
        error.hook_moved_mm.assign(field.hooks.size(), 0.0);
    }

    std::string content_of(const fs::path& path)
    {
        std::ifstream in(path, std::ios::binary);
        return { std::istreambuf_iterator<char>(in), {} };
    }

    TEST(Metrics, DocumentHasTheContractsKeys)
    {
        const auto document = metrics_document({ sample_field("median") });
        const auto& field = document.at("approaches").at(0);
        for (const char* key : { "name", "seen_best_eye", "best_eye", "visible_fraction", "opening_area_mm2",
                 "opening_width_mm", "working_distance_mm", "incision_length_mm", "hook_force_N", "hook_forces_N",
                 "strain_p99", "inverted_elements", "max_volume_ratio", "bone_in_sight", "tets", "seconds", "solution",
                 "residual", "mechanics_status" })
            EXPECT_TRUE(field.contains(key)) << key;
        EXPECT_EQ(document.at("frame"), "LPS");
        EXPECT_EQ(field.at("hook_forces_N").size(), 3u);
        EXPECT_DOUBLE_EQ(field.at("side_forces_N").at(0).get<double>(), 22.5);
        EXPECT_DOUBLE_EQ(field.at("side_forces_N").at(1).get<double>(), 7.0);
        EXPECT_DOUBLE_EQ(field.at("seconds").at("mesh").get<double>(), 1.5);
    }

    TEST(Metrics, ErrorBarsAndASecondOpinionAreThereWhenTheyWereMade)
    {
        FieldMetrics field = sample_field("median");
        EXPECT_FALSE(metrics_document({ field }).at("approaches").at(0).contains("error_estimate"));
        EXPECT_EQ(error_text(field), "error not estimated");
        field.opening_width_mm = 62.1;
        ErrorBars& error = field.error.emplace();
        error.opening_width_mm = 1.3;
        error.seen_best_eye = 0.021;
        error.hook_forces_N = { 1.0, 1.5, 0.5 };
        error.side_forces_N[0] = 2.5;
        error.hook_force_N = 2.5;
        SecondOpinion& opinion = field.second_opinion.emplace();
        opinion.program = "CalculiX (ccx)";
        opinion.status = "agrees";
        opinion.displacement_difference = 2e-7;
        const auto document = metrics_document({ field }).at("approaches").at(0);
        EXPECT_DOUBLE_EQ(document.at("error_estimate").at("opening_width_mm").get<double>(), 1.3);
        EXPECT_DOUBLE_EQ(document.at("error_estimate").at("seen_best_eye").get<double>(), 0.021);
        EXPECT_DOUBLE_EQ(document.at("error_estimate").at("hook_forces_N").at(1).get<double>(), 1.5);
        EXPECT_DOUBLE_EQ(document.at("error_estimate").at("side_forces_N").at(0).get<double>(), 2.5);
        EXPECT_EQ(document.at("second_opinion").at("status"), "agrees");
        EXPECT_DOUBLE_EQ(document.at("second_opinion").at("displacement_difference").get<double>(), 2e-7);
        EXPECT_NE(error_text(field).find("opening 62.1 mm +- 1.3, force 22.5 N +- 2.5, seen 25.0 % +- 2.1"),
            std::string::npos);
        FieldMetrics driven = field; // what all hooks' forces are was asked for
        for (HookForce& hook : driven.hooks)
            hook.pull.force_N = 10.0;
        EXPECT_NE(error_text(driven).find("opening 62.1 mm +- 1.3 under a known force of 22.5 N"), std::string::npos);
        driven.hooks.back().pull.force_N.reset();
        EXPECT_FALSE(forces_are_known(driven));
        driven.hooks.back().yielded = true;
        EXPECT_TRUE(forces_are_known(driven));
        EXPECT_NE(opinion_text(*field.second_opinion).find("agrees"), std::string::npos);
        field.error->message = "the wound did not open as requested";
        field.second_opinion->status = "failed";
        field.second_opinion->message = "ccx died";
        const auto none = metrics_document({ field }).at("approaches").at(0);
        EXPECT_FALSE(none.at("error_estimate").contains("opening_width_mm"));
        EXPECT_FALSE(none.at("second_opinion").contains("displacement_difference"));
        EXPECT_EQ(none.at("second_opinion").at("message"), "ccx died");
    }

    TEST(Report, SaysTheReachedAccuracyInASentence)
    {
        FieldMetrics field = sample_field("median");
        add_bars(field, 1.2, 2.0);
        const fs::path path = fs::path(::testing::TempDir()) / "report_accuracy.html";
        const auto written = [&] {
            Report report;
            report.fields = { field };
            write_report(path, report);
            return content_of(path);
        };
        EXPECT_EQ(written().find("is known to"), std::string::npos);
        field.accuracy = AccuracyMetrics { .reached_force = 0.09, .reached_opening_mm = 1.2, .edge_mm = 8.0 };
        EXPECT_NE(written().find("<p>The force is known to 9 % (asked: 15 %)."), std::string::npos);
        field.accuracy->ended_by = AccuracyEnd::time;
        field.accuracy->reached_force = 0.22;
        EXPECT_NE(written().find("<p class=\"notice\">The asked accuracy of 15 % and 2 mm was not reached within "
                                 "600 s; the force is known to 22 %"),
            std::string::npos);
    }

    TEST(Metrics, TheDivisionIsThereWhereTheSpaceIsDividedBeyondTheSkin)
    {
        FieldMetrics field = sample_field("intercostal_4");
        EXPECT_FALSE(metrics_document({ field }).at("approaches").at(0).contains("division"));
        EXPECT_EQ(division_text(field), "");
        EXPECT_EQ(division_cell(field), "skin only");
        field.division = { .labels = { "intercostal" },
            .length_mm = 279.0,
            .forwards_mm = 62.0,
            .backwards_mm = 47.0,
            .severed_mm2 = 1090.0,
            .words = "in the left intercostal space 4" };
        const auto document = metrics_document({ field });
        const auto& division = document.at("approaches").at(0).at("division");
        EXPECT_EQ(division.at("labels").at(0), "intercostal");
        EXPECT_DOUBLE_EQ(division.at("length_mm").get<double>(), 279.0);
        EXPECT_DOUBLE_EQ(division.at("forwards_mm").get<double>(), 62.0);
        EXPECT_DOUBLE_EQ(division.at("backwards_mm").get<double>(), 47.0);
        EXPECT_DOUBLE_EQ(division.at("severed_mm2").get<double>(), 1090.0);
        EXPECT_EQ(division_cell(field), "47 mm backwards, 62 mm forwards");
        EXPECT_EQ(division_text(field),
            "in the left intercostal space 4; the division is 279 mm long with the incision, and severs 10.9 cm2 "
            "beyond "
            "it");
        field.division = DividedTissue { .length_mm = 70.0, .words = "not backwards (the ribs join)" };
        EXPECT_EQ(division_cell(field), "skin only, although more was asked for");
        EXPECT_EQ(division_text(field), "not backwards (the ribs join)");
    }

    TEST(Report, SetsSkinLengthAndFullDivisionSideBySide)
    {
        FieldMetrics skin = sample_field("intercostal_4_skin"), full = sample_field("intercostal_4");
        full.division = { .length_mm = 279.0, .forwards_mm = 62.0, .backwards_mm = 47.0 };
        const fs::path path = fs::path(testing::TempDir()) / "division.html";
        Report report;
        report.title = "Comparison";
        report.fields = { skin, full };
        write_report(path, report);
        const std::string both = content_of(path);
        EXPECT_NE(
            both.find("Intercostal space divided beyond the skin</td><td>skin only</td><td>47 mm backwards, 62 mm "
                      "forwards</td>"),
            std::string::npos);
        report.fields = { skin };
        write_report(path, report);
        EXPECT_EQ(content_of(path).find("divided beyond the skin"), std::string::npos);
    }

    TEST(Report, SaysWhatToThinkOfFirstAndRanksApproachesOfOneTarget)
    {
        FieldMetrics open = sample_field("median"), between = sample_field("intercostal_4");
        between.seen_best_eye = 0.5 * open.seen_best_eye;
        for (FieldMetrics* field : { &open, &between })
            field->mechanics_status = "converged";
        const fs::path path = fs::path(testing::TempDir()) / "ranking.html";
        Report report;
        report.fields = { open, between };
        report.divided_bones = { { "sternum" }, {} };
        write_report(path, report);
        const std::string page = content_of(path);
        EXPECT_NE(page.find("<h2>Think of this first</h2>"), std::string::npos);
        EXPECT_NE(page.find("The sternum is sawn through."), std::string::npos);
        EXPECT_NE(page.find("<h2>Score</h2>"), std::string::npos);
        EXPECT_NE(page.find("What each approach shows against what it spares"), std::string::npos);
        EXPECT_LT(page.find("Think of this first"), page.find("<h2>Comparison</h2>"));

        report.fields[1].target = "clamp site on aorta";
        write_report(path, report);
        EXPECT_NE(content_of(path).find("The approaches have different targets"), std::string::npos);
        EXPECT_EQ(content_of(path).find("Score of 100"), std::string::npos);
        report.fields.pop_back();
        report.divided_bones.clear();
        write_report(path, report);
        EXPECT_EQ(content_of(path).find("<h2>Score</h2>"), std::string::npos) << "one alone has no place";
    }

    TEST(Report, SetsNeighboursBesideAnApproach)
    {
        FieldMetrics field = sample_field("intercostal_4"), higher = field;
        for (FieldMetrics* one : { &field, &higher })
            add_bars(*one, 1.0, 1.0, 0.01);
        higher.seen_best_eye = 0.5 * field.seen_best_eye;
        const fs::path path = fs::path(testing::TempDir()) / "neighbours.html";
        Report report;
        report.fields = { field };
        report.neighbours = { { { .where = "one space higher", .field = higher },
            { .where = "one space lower", .missing = "no voxel is labelled \"rib_left_9\"" } } };
        write_report(path, report);
        std::string page = content_of(path);
        EXPECT_NE(page.find("<h2>One space higher or lower</h2>"), std::string::npos);
        EXPECT_NE(page.find("<th>one space higher</th>"), std::string::npos);
        EXPECT_NE(page.find("worse by more than both errors"), std::string::npos) << "half as much is seen";
        EXPECT_NE(page.find("Without a plan: one space lower: no voxel is labelled &quot;rib_left_9&quot;."),
            std::string::npos);
        report.neighbours = { { { .where = "one space higher", .missing = "not planned" } } };
        write_report(path, report);
        page = content_of(path);
        EXPECT_NE(page.find("<p>intercostal_4: one space higher: not planned.</p>"), std::string::npos);
        EXPECT_EQ(page.find("<th>one space higher</th>"), std::string::npos);
        report.neighbours = { {} };
        write_report(path, report);
        EXPECT_EQ(content_of(path).find("One space higher"), std::string::npos);
    }

    TEST(Metrics, ContactIsSaid)
    {
        FieldMetrics field = sample_field("median");
        ContactMetrics& contact = field.contact.emplace();
        EXPECT_EQ(contact_text(field), "contact: nothing touches");
        contact = { .touching = 23, .largest_penetration_mm = 0.25, .force_N = 94.0, .overlap_at_rest_mm = 2.35 };
        EXPECT_EQ(contact_text(field),
            "contact: 23 points touch, with 94.0 N in total and a penetration of at most 0.25 mm; surfaces that "
            "overlap by up to 2.35 mm at rest keep this overlap");
        EXPECT_FALSE(passes_through(field));
        EXPECT_FALSE(metrics_document({ field }).at("approaches").at(0).at("contact").contains("needed"));
    }

    TEST(Metrics, SurfacesThatPassThroughEachOtherAreACaution)
    {
        FieldMetrics field = sample_field("median");
        field.contact = ContactMetrics { .needed = false, .computed = false };
        EXPECT_EQ(contact_text(field), "contact: nothing touches");
        EXPECT_FALSE(passes_through(field));
        EXPECT_EQ(metrics_document({ field }).at("approaches").at(0).at("contact").at("needed"), false);
        field.contact->largest_penetration_mm = 3.64;
        field.contact->with = "upper_abdomen";
        EXPECT_EQ(contact_text(field), "contact: the wall sinks up to 3.6 mm into the upper abdomen, which gives way");
        EXPECT_FALSE(passes_through(field));
        field.contact = ContactMetrics { .needed = true,
            .computed = false,
            .largest_penetration_mm = 3.24,
            .at = Vec3(12.0, -80.4, 33.0),
            .place = "38 mm along the incision, 4 mm beside it and 12 mm deep",
            .with = "lung_left",
            .message = "no equilibrium with contact was found in 30 s" };
        EXPECT_TRUE(passes_through(field));
        EXPECT_EQ(contact_text(field),
            "contact: the wall passes through the left lung by up to 3.2 mm, 38 mm along the incision, 4 mm "
            "beside it and 12 mm deep in the opened wound, which contact would prevent; contact was not computed: no "
            "equilibrium with contact was found in 30 s");
        const auto document = metrics_document({ field }).at("approaches").at(0).at("contact");
        EXPECT_EQ(document.at("needed"), true);
        EXPECT_EQ(document.at("computed"), false);
        EXPECT_EQ(document.at("with"), "lung_left");
        EXPECT_EQ(document.at("at_mm").at(1), -80.4);
        EXPECT_EQ(document.at("message"), "no equilibrium with contact was found in 30 s");
        const fs::path path = fs::path(::testing::TempDir()) / "report_contact.html";
        Report report;
        report.fields = { field };
        write_report(path, report);
        EXPECT_NE(content_of(path).find("<p class=\"notice\">contact: the wall passes"), std::string::npos);
        field.contact->with.clear();
        EXPECT_NE(contact_text(field).find("the wall passes through itself by up to 3.2 mm"), std::string::npos);
        field.contact->needed.reset();
        EXPECT_FALSE(passes_through(field));
        EXPECT_NE(contact_text(field).find("contact: not tested"), std::string::npos);
    }

    TEST(Metrics, HowAFieldWasSolvedIsSaid)
    {
        FieldMetrics field = sample_field("median");
        const auto usual = metrics_document({ field });
        EXPECT_EQ(usual.at("approaches").at(0).at("solution").at("elasticity"), "corotational");
        EXPECT_EQ(usual.at("approaches").at(0).at("solution").at("element"), "p1");
        EXPECT_EQ(usual.at("approaches").at(0).at("solution").at("poissons_ratio_at_most"), 0.45);
        FieldMetrics other = sample_field("distal");
        other.tets = 9000;
        other.solution = { .choice = { fem::Elasticity::hyperelastic, ElementKind::p2, 40.0 },
            .nodes = 12345,
            .laws = { { "skin", "neo-Hookean" }, { "muscle", "Guccione" } },
            .near_tets = 4000 };
        WholeMetrics& whole = other.solution.whole.emplace();
        whole.hook_force_N = 20.1;
        const auto document = metrics_document({ field, other });
        const auto& solution = document.at("approaches").at(1).at("solution");
        EXPECT_EQ(solution.at("elasticity"), "hyperelastic");
        EXPECT_EQ(solution.at("element"), "p2");
        EXPECT_EQ(solution.at("nodes"), 12345);
        EXPECT_EQ(solution.at("laws").at("muscle"), "Guccione");
        EXPECT_DOUBLE_EQ(solution.at("near_mm").get<double>(), 40.0);
        EXPECT_EQ(solution.at("near_tets"), 4000);
        EXPECT_DOUBLE_EQ(solution.at("whole").at("hook_force_N").get<double>(), 20.1);
        EXPECT_FALSE(solution.contains("poissons_ratio_at_most"));
        const std::string said = solution_text(other);
        for (const char* part :
            { "hyperelastic within 40 mm of the lips, linear beyond", "ten-node", "neo-Hookean but muscle: Guccione",
                "4000 of 9000 elements nonlinear", "the whole wall nonlinear: opening 0.0 mm, force 20.1 N" })
            EXPECT_NE(said.find(part), std::string::npos) << said;
    }

    TEST(Metrics, NumbersThatAreNotFiniteAreRefusedByName)
    {
        FieldMetrics bad = sample_field("distal");
        bad.strain_p99 = std::numeric_limits<double>::quiet_NaN();
        try {
            (void)metrics_document({ bad });
            FAIL() << "NaN was written";
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "approach distal");
            EXPECT_NE(std::string(error.what()).find("strain_p99"), std::string::npos);
        }
    }

    TEST(Report, IsSelfContainedAndEscapesText)
    {
        const fs::path folder = fs::path(testing::TempDir()) / "report";
        fs::create_directories(folder);
        std::ofstream(folder / "a.png", std::ios::binary) << "Man";
        Report report;
        report.title = "Fields <1 & 2>";
        report.fields = { sample_field("median"), sample_field("distal") };
        report.fields[1].seen_best_eye = 0.5;
        for (FieldMetrics& field : report.fields)
            add_bars(field, 2.0, 1.0, 0.014);
        report.pictures = { { "median", "The surgeon's eye", folder / "a.png" } };
        write_report(folder / "report.html", report);
        const std::string html = content_of(folder / "report.html");
        EXPECT_NE(html.find("Fields &lt;1 &amp; 2&gt;"), std::string::npos);
        EXPECT_NE(html.find("data:image/png;base64,TWFu\""), std::string::npos); // "Man", RFC 4648
        EXPECT_NE(html.find("<td class=\"best\">50.0 % &plusmn; 1.4 %</td>"), std::string::npos);
        EXPECT_EQ(html.find("src=\"http"), std::string::npos);
        EXPECT_NE(html.find("not a medical device"), std::string::npos);
    }

    std::string html_of(const std::vector<FieldMetrics>& fields)
    {
        Report report;
        report.fields = fields;
        const fs::path file = fs::path(testing::TempDir()) / "report_of_fields.html";
        write_report(file, report);
        return content_of(file);
    }

    TEST(Report, NamesTheMomentOfTheForce)
    {
        FieldMetrics slow = sample_field("slow"), fast = sample_field("fast");
        EXPECT_EQ(html_of({ slow, fast }).find("its moment"), std::string::npos);
        slow.force_moments = ForceMoments { .peak_N = 260.0,
            .held_N = 49.4,
            .held_least_N = 25.8,
            .held_most_N = 73.0,
            .opened_in_s = 80.0,
            .hold_s = 300.0,
            .protocol = "half a turn of the crank (7 mm) every 10 s" };
        fast.force_moments = slow.force_moments;
        EXPECT_NE(html_of({ slow, fast }).find("260 N at the last turn, about 49 N after 5 minutes (26 to 73 N"),
            std::string::npos);
        EXPECT_EQ(html_of({ slow, fast }).find("Caution, speed of opening"), std::string::npos);
        fast.force_moments->is_fast = true;
        EXPECT_NE(html_of({ slow, fast }).find("Caution, speed of opening"), std::string::npos);
    }

    TEST(Report, MarksOnlyALeadBeyondBothErrorBars)
    {
        FieldMetrics a = sample_field("a"), b = sample_field("b");
        a.seen_best_eye = 0.50, b.seen_best_eye = 0.46;
        a.seen_two_eyes = 0.40, b.seen_two_eyes = 0.37;
        add_bars(a, 2.0, 1.0, 0.022); // 5 % of the opening
        add_bars(b, 2.0, 1.0, 0.022);
        a.hook_force_N = 20.0, b.hook_force_N = 21.9;
        std::string html = html_of({ a, b });
        EXPECT_EQ(html.find("class=\"best\">50.0 %"), std::string::npos) << "4 points are within 2.2 + 2.2";
        EXPECT_EQ(html.find("class=\"best\">40.0 %"), std::string::npos) << "0.03 is within the 2.2 points of either";
        EXPECT_EQ(html.find("class=\"best\">20.0 N"), std::string::npos) << "1.9 N is within 1 + 1 N";
        b.hook_force_N = 22.1, b.seen_best_eye = 0.45, b.seen_two_eyes = 0.35;
        html = html_of({ a, b });
        EXPECT_NE(html.find("class=\"best\">20.0 N"), std::string::npos);
        EXPECT_NE(html.find("class=\"best\">50.0 %"), std::string::npos);
        EXPECT_NE(html.find("class=\"best\">40.0 %"), std::string::npos);
        EXPECT_NE(html.find("whose bar is 5.0 % (a), 5.0 % (b) of its width"), std::string::npos);
        b.error->message = "not converged";
        html = html_of({ a, b });
        EXPECT_EQ(html.find("class=\"best\">20.0 N"), std::string::npos) << "an unknown error is no lead";
        EXPECT_NE(html.find("5.0 % (a), not estimated (b)"), std::string::npos);
    }

    TEST(Report, AFailedPlanIsNamedAndIsNoLead)
    {
        FieldMetrics a = sample_field("a"), b = sample_field("b"), c = sample_field("c");
        for (FieldMetrics* field : { &a, &b, &c })
            add_bars(*field, 2.0, 1.0);
        a.hook_force_N = 10.0;
        EXPECT_NE(html_of({ a, b, c }).find("class=\"best\">10.0 N"), std::string::npos);
        a.volume_failures = VolumeFailures { .elements = 3, .share = 0.02, .smallest_ratio = 0.5, .believable = false };
        const std::string html = html_of({ a, b, c });
        EXPECT_EQ(html.find("class=\"best\">10.0 N"), std::string::npos);
        EXPECT_NE(
            html.find("a not usable: these numbers are not to be believed: 2 % of the soft tissue"), std::string::npos);
        EXPECT_EQ(html.find("b not usable"), std::string::npos);
        // The first sentence of the page says so, beside the colour of its light.
        const std::size_t first
            = html.find("<p class=\"verdict unknown\"><b>A a: Not usable.</b> " + why_not_to_use(a));
        ASSERT_NE(first, std::string::npos);
        EXPECT_LT(first, html.find("Think of this first"));
    }

    TEST(Report, ImplausibleNumbersThatTheCaseAcceptsAreNamed)
    {
        FieldMetrics field = sample_field("a");
        EXPECT_EQ(html_of({ field }).find("Accepted although implausible"), std::string::npos);
        field.implausible = { "the depth of the cut is 0.04 mm" };
        EXPECT_NE(html_of({ field }).find("Accepted although implausible: the depth of the cut is 0.04 mm"),
            std::string::npos);
    }

    TEST(Report, DrawsWhiskersAndNamesTheHooksThatYielded)
    {
        FieldMetrics field = sample_field("a");
        EXPECT_EQ(html_of({ field }).find("whisker"), std::string::npos);
        EXPECT_EQ(html_of({ field }).find("Hooks that yielded"), std::string::npos);
        add_bars(field, 2.0, 1.0);
        field.hooks[1] = { .name = "left 2",
            .side = 1,
            .force_N = 12.5,
            .moved_mm = 20.0,
            .asked_mm = 30.0,
            .pull = { .force_limit_N = 12.5 },
            .yielded = true };
        field.error->hook_moved_mm[1] = 0.7;
        const std::string html = html_of({ field });
        // 40 mm +- 2: the longest reaches 390 px from x = 12 on at 42 mm.
        EXPECT_NE(html.find("class=\"whisker\" d=\"M364.9 69H402.0"), std::string::npos);
        EXPECT_NE(html.find("<td>Hooks that yielded</td><td>left 2 at 12.5 N: 20.0 &plusmn; 0.7 of 30.0 mm</td>"),
            std::string::npos);
    }

    TEST(Report, WritesTissueValuesWithoutPowersOfTenAndZeroWithoutASign)
    {
        Report report;
        report.fields = { sample_field("a") };
        ParameterInterval& interval = report.fields[0].parameters.emplace();
        interval.parameters = { { .name = "rib",
                                    .unit = "MPa",
                                    .value = 6114.0,
                                    .low = 4028.0,
                                    .high = 9267.0,
                                    .force_change_percent = 7.66,
                                    .opening_change_percent = -0.02,
                                    .source = "tested ribs" },
            { .name = "skin", .unit = "MPa", .value = 0.2, .low = 0.1154, .high = 0.3462, .source = "tested skin" } };
        const fs::path path = fs::path(::testing::TempDir()) / "report_values.html";
        write_report(path, report);
        const std::string html = content_of(path);
        for (const char* part : { "<td>6110 MPa</td><td>4030 to 9270</td><td>+7.7 %</td><td>0.0 %</td>",
                 "<td>0.2 MPa</td><td>0.115 to 0.346</td>" })
            EXPECT_NE(html.find(part), std::string::npos) << part;
    }

    TEST(Report, SaysWhatWasComputedAndTheOpeningAskedFor)
    {
        Report report;
        report.fields = { sample_field("a") };
        report.fields[0].hooks = { { .name = "left", .side = 1, .moved_mm = 18.0, .asked_mm = 30.0 },
            { .name = "right", .side = -1, .moved_mm = 20.0, .asked_mm = 30.0 } };
        Provenance& computed = report.computed.emplace();
        computed.date = "2026-01-02T03:04:05Z";
        computed.program = "retractor 9.9";
        computed.case_file = "C/case.json";
        fem::Material& skin = computed.materials.emplace_back();
        skin.name = "skin";
        skin.youngs_modulus_MPa = 0.123;
        skin.poissons_ratio = 0.45;
        const fs::path file = fs::path(testing::TempDir()) / "report_computed.html";
        write_report(file, report);
        const std::string html = content_of(file);
        for (const char* part : { "2026-01-02T03:04:05Z, by retractor 9.9", "C/case.json", "<td>0.123 MPa</td>",
                 "from side to side</td><td>60.0 mm</td>", "tissue under them</td><td>38.0 mm</td>" })
            EXPECT_NE(html.find(part), std::string::npos) << part;
    }

    FieldMetrics with_broken_rib()
    {
        FieldMetrics field = sample_field("a");
        field.attainable = Attainable::with_injury;
        field.largest_uninjured_opening_mm = 27.4;
        field.bones = { { .name = "rib_left_5",
            .at_mm = 96.0,
            .length_mm = 240.0,
            .part = "lateral",
            .place = { 1.0, 2.0, 3.0 },
            .section_mm2 = 75.0,
            .bending_Nm = 3.4,
            .torsion_Nm = 0.5,
            .moment_Nm = 3.42,
            .capacity_Nm = 2.9,
            .utilisation = 1.18,
            .opening_at_limit_mm = 27.4,
            .spine_joint = JointLoad { 30.0, 0.2 } } };
        return field;
    }

    TEST(Metrics, BonesHaveTheirMomentsAndThePlanItsVerdict)
    {
        FieldMetrics sternum = sample_field("b");
        sternum.attainable = Attainable::yes;
        sternum.largest_uninjured_opening_mm = 40.0;
        sternum.bones = { { .name = "sternum", .moment_Nm = 2.0 } };
        const auto document = metrics_document({ with_broken_rib(), sternum, sample_field("c") }).at("approaches");
        const auto& broken = document.at(0);
        EXPECT_EQ(broken.at("attainable"), "with_injury");
        EXPECT_DOUBLE_EQ(broken.at("largest_uninjured_opening_mm").get<double>(), 27.4);
        EXPECT_TRUE(broken.at("largest_uninjured_opening_is_estimate").get<bool>());
        const auto& rib = broken.at("bones").at(0);
        EXPECT_EQ(rib.at("part"), "lateral");
        EXPECT_DOUBLE_EQ(rib.at("capacity_Nm").get<double>(), 2.9);
        EXPECT_DOUBLE_EQ(rib.at("opening_at_limit_mm").get<double>(), 27.4);
        EXPECT_DOUBLE_EQ(rib.at("spine_joint").at("force_N").get<double>(), 30.0);
        EXPECT_FALSE(rib.contains("cartilage"));
        EXPECT_EQ(document.at(1).at("bones").at(0).at("capacity"), "no published number");
        EXPECT_FALSE(document.at(1).at("largest_uninjured_opening_is_estimate").get<bool>());
        EXPECT_EQ(document.at(2).at("attainable"), "unknown");
        EXPECT_FALSE(document.at(2).contains("largest_uninjured_opening_mm"));
    }

    TEST(Report, ForetellsAFractureWithTheLargestOpeningWithoutOne)
    {
        const std::string html = html_of({ with_broken_rib(), sample_field("b") });
        for (const char* part :
            { "<span class=\"caution\">with injury: rib 5 on the left</span>", "<td>27 mm</td><td>not known</td>",
                "Rib 5 on the left would break in its lateral part, 96 mm from the spine, from an opening of about 27 "
                "mm on",
                "no published number for what joint and cartilage bear" })
            EXPECT_NE(html.find(part), std::string::npos) << part;
        EXPECT_EQ(html_of({ sample_field("b") }).find("without a fracture"), std::string::npos);
    }

    TEST(Report, SaysWhereSkinTearsAndDrawsHowTheLipsFollow)
    {
        EXPECT_EQ(html_of({ sample_field("b") }).find("<svg class=\"lips\""), std::string::npos);
        EXPECT_EQ(html_of({ sample_field("b") }).find("Caution, tearing"), std::string::npos);
        FieldMetrics field = sample_field("a");
        field.tissue_strain = { { "skin", 0.82, Vec3::Zero(), "38 mm along the incision" } };
        field.attainable = Attainable::with_injury;
        field.lip_deviation = { { .side = 1,
            .largest_mm = 4.5,
            .mean_mm = 1.5,
            .at_mm = 40.0,
            .from_mm = 10.0,
            .to_mm = 90.0,
            .curve = { { 0.0, 6.0 }, { 50.0, -1.0 }, { 100.0, 6.0 } } } };
        const std::string html = html_of({ field, sample_field("b") });
        for (const char* part : { "with injury: skin", "<td>skin 82 %</td>", "Caution, tearing",
                 "skin would tear: 82 % 38 mm along the incision, torn samples failed between 37 and 71 %",
                 "the left lip lies up to 4.5 mm (mean 1.5 mm) off the line of its hooks", "<svg class=\"lips\"",
                 "<polyline fill=\"none\" stroke-width=\"2\" stroke=\"#3a7ca5\" points=\"60.0,190.0 300.0,40.0 "
                 "540.0,190.0 \"",
                 "100 mm along the incision" })
            EXPECT_NE(html.find(part), std::string::npos) << part;
        EXPECT_EQ(html.find("without a fracture"), std::string::npos) << "no bone breaks";
    }

    TEST(Report, AMissingPictureLeavesTheOldReportAlone)
    {
        const fs::path folder = fs::path(testing::TempDir()) / "report_kept";
        fs::create_directories(folder);
        std::ofstream(folder / "report.html") << "old";
        Report report;
        report.pictures = { { "", "lost", folder / "no-such.png" } };
        EXPECT_THROW(write_report(folder / "report.html", report), IoError);
        EXPECT_EQ(content_of(folder / "report.html"), "old");
    }

} // namespace report_test
} // namespace retractor::planner
