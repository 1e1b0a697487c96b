#include "planner/measures/report.h"

#include "mesh/base/error.h"
#include "planner/measures/metrics.h"

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
        m.visible_fraction = 0.25;
        m.mechanics_status = "converged";
        m.hooks = { { "left 1", 1, 10.0 }, { "left 2", 1, 12.5 }, { "right 1", -1, 7.0 } };
        m.hook_force_N = 22.5;
        m.bone_in_sight = { "rib_left_4" };
        m.seconds = { { "mesh", 1.5 }, { "cut", 0.25 } };
        return m;
    }

    void add_bars(FieldMetrics& field, double opening_mm, double force_N)
    {
        field.opening_width_mm = 40.0;
        ErrorBars& error = field.error.emplace();
        error.opening_width_mm = opening_mm;
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
        for (const char* key :
            { "name", "visible_fraction", "opening_area_mm2", "opening_width_mm", "working_distance_mm",
                "incision_length_mm", "hook_force_N", "hook_forces_N", "strain_p99", "inverted_elements",
                "max_volume_ratio", "bone_in_sight", "tets", "seconds", "solution", "residual", "mechanics_status" })
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
        error.hook_forces_N = { 1.0, 1.5, 0.5 };
        error.side_forces_N[0] = 2.5;
        error.hook_force_N = 2.5;
        SecondOpinion& opinion = field.second_opinion.emplace();
        opinion.program = "CalculiX (ccx)";
        opinion.status = "agrees";
        opinion.displacement_difference = 2e-7;
        const auto document = metrics_document({ field }).at("approaches").at(0);
        EXPECT_DOUBLE_EQ(document.at("error_estimate").at("opening_width_mm").get<double>(), 1.3);
        EXPECT_DOUBLE_EQ(document.at("error_estimate").at("hook_forces_N").at(1).get<double>(), 1.5);
        EXPECT_DOUBLE_EQ(document.at("error_estimate").at("side_forces_N").at(0).get<double>(), 2.5);
        EXPECT_EQ(document.at("second_opinion").at("status"), "agrees");
        EXPECT_DOUBLE_EQ(document.at("second_opinion").at("displacement_difference").get<double>(), 2e-7);
        EXPECT_NE(error_text(field).find("opening 62.1 mm +- 1.3, force 22.5 N +- 2.5"), std::string::npos);
        FieldMetrics driven = field; // what all hooks' forces are was asked for
        for (HookForce& hook : driven.hooks)
            hook.pull.force_N = 10.0;
        EXPECT_NE(error_text(driven).find("opening 62.1 mm +- 1.3 under a known force of 22.5 N"), std::string::npos);
        driven.hooks.back().pull.force_N.reset();
        EXPECT_FALSE(forces_are_known(driven));
        driven.hooks.back().yielded = true;
        EXPECT_TRUE(forces_are_known(driven));
        EXPECT_NE(opinion_text(*field.second_opinion).find("agrees"), std::string::npos);
        field.error->message = "the wound was not opened as asked";
        field.second_opinion->status = "failed";
        field.second_opinion->message = "ccx died";
        const auto none = metrics_document({ field }).at("approaches").at(0);
        EXPECT_FALSE(none.at("error_estimate").contains("opening_width_mm"));
        EXPECT_FALSE(none.at("second_opinion").contains("displacement_difference"));
        EXPECT_EQ(none.at("second_opinion").at("message"), "ccx died");
    }

    TEST(Metrics, ContactIsSaid)
    {
        FieldMetrics field = sample_field("median");
        ContactMetrics& contact = field.contact.emplace();
        EXPECT_EQ(contact_text(field), "contact: nothing touches");
        contact = { .touching = 23, .largest_penetration_mm = 0.25, .force_N = 94.0, .overlap_at_rest_mm = 2.35 };
        EXPECT_EQ(contact_text(field),
            "contact: 23 points hold each other off with 94.0 N in all, at most 0.25 mm into each other; surfaces that "
            "overlap by up to 2.35 mm at rest are left so");
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
                "4000 of 9000 elements nonlinear", "all of them nonlinear: opening 0.0 mm, force 20.1 N" })
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
        report.fields[1].visible_fraction = 0.5;
        for (FieldMetrics& field : report.fields)
            add_bars(field, 2.0, 1.0);
        report.pictures = { { "median", "The surgeon's eye", folder / "a.png" } };
        write_report(folder / "report.html", report);
        const std::string html = content_of(folder / "report.html");
        EXPECT_NE(html.find("Fields &lt;1 &amp; 2&gt;"), std::string::npos);
        EXPECT_NE(html.find("data:image/png;base64,TWFu\""), std::string::npos); // "Man", RFC 4648
        EXPECT_NE(html.find("<td class=\"best\">50.0 %</td>"), std::string::npos);
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

    TEST(Report, MarksOnlyALeadBeyondBothErrorBars)
    {
        FieldMetrics a = sample_field("a"), b = sample_field("b");
        a.visible_fraction = 0.50, b.visible_fraction = 0.46;
        add_bars(a, 2.0, 1.0); // 5 % of the opening
        add_bars(b, 2.0, 1.0);
        a.hook_force_N = 20.0, b.hook_force_N = 21.9;
        std::string html = html_of({ a, b });
        EXPECT_EQ(html.find("class=\"best\">50.0 %"), std::string::npos) << "0.04 is within 5 % of either";
        EXPECT_EQ(html.find("class=\"best\">20.0 N"), std::string::npos) << "1.9 N is within 1 + 1 N";
        b.hook_force_N = 22.1, b.visible_fraction = 0.45;
        html = html_of({ a, b });
        EXPECT_NE(html.find("class=\"best\">20.0 N"), std::string::npos);
        EXPECT_NE(html.find("class=\"best\">50.0 %"), std::string::npos);
        EXPECT_NE(html.find("whose bar is 5.0 % (a), 5.0 % (b) of its width"), std::string::npos);
        b.error->message = "not converged";
        html = html_of({ a, b });
        EXPECT_EQ(html.find("class=\"best\">20.0 N"), std::string::npos) << "an unknown error is no lead";
        EXPECT_NE(html.find("5.0 % (a), not estimated (b)"), std::string::npos);
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
        // 40 mm +- 2: the longest reaches 250 px from x = 150 on at 42 mm.
        EXPECT_NE(html.find("class=\"whisker\" d=\"M376.2 53H400.0"), std::string::npos);
        EXPECT_NE(html.find("<td>Hooks that yielded</td><td>left 2 at 12.5 N: 20.0 &plusmn; 0.7 of 30.0 mm</td>"),
            std::string::npos);
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
                 "opposite hooks</td><td>60.0 mm</td>", "tissue under them</td><td>38.0 mm</td>" })
            EXPECT_NE(html.find(part), std::string::npos) << part;
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
