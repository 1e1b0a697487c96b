#include "planner/measures/hook_opening.h"
#include "planner/measures/provenance.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chrono>

namespace retractor::planner {
namespace computation_test {

    constexpr auto kWhen = std::chrono::system_clock::time_point(std::chrono::seconds(1'700'000'000));

    Case named_case()
    {
        Case c;
        c.folder = "/somewhere/private/Doe-study";
        c.patient = datasets::PatientIdentity { .name = "Doe^Jane", .id = "4711-x" };
        c.labels = { "labels.nrrd", std::string(64, 'a') };
        c.ct = FileReference { "ct.nrrd", std::string(64, 'b') };
        c.label_table = { { .id = 1, .name = "skin", .material = "skin", .role = mesh::Role::wall },
            { .id = 2, .name = "fold", .material = "skin", .role = mesh::Role::wall },
            { .id = 3, .name = "heart", .material = "heart", .role = mesh::Role::target } };
        return c;
    }

    TEST(Provenance, SaysWhenByWhatFromWhichImagesAndWithWhichTissue)
    {
        Case c = named_case();
        for (fem::Material& material : c.materials)
            if (material.name == "skin") {
                material.youngs_modulus_MPa = 0.123;
                material.poissons_ratio = 0.49;
            }
        const auto json = provenance_document(provenance_of(c, "retractor 9.9", kWhen));
        EXPECT_EQ(json.at("date"), "2023-11-14T22:13:20Z"); // 1.7e9 s after the epoch
        EXPECT_EQ(json.at("program"), "retractor 9.9");
        EXPECT_EQ(json.at("labels").at("sha256"), std::string(64, 'a'));
        EXPECT_EQ(json.at("ct").at("path"), "ct.nrrd");
        ASSERT_EQ(json.at("materials").size(), 1u) << "each material of the wall once, of organs none";
        EXPECT_EQ(json.at("materials").at(0).at("youngs_modulus_MPa"), 0.123);
        EXPECT_EQ(json.at("materials").at(0).at("poissons_ratio"), 0.45) << "as four-node elements take it";
        c.solution.element = ElementKind::p2;
        EXPECT_EQ(provenance_of(c, "", kWhen).materials.at(0).poissons_ratio, 0.49);
    }

    TEST(Provenance, RepeatsNoNameAndNoPathOfAPerson)
    {
        const Provenance made = provenance_of(named_case(), "retractor", kWhen);
        EXPECT_EQ(made.case_file, "[withheld]-study/case.json");
        std::string said = provenance_document(made).dump();
        for (const auto& [what, value] : provenance_rows(made))
            said += value;
        for (const char* secret : { "Doe", "Jane", "4711", "private" })
            EXPECT_EQ(said.find(secret), std::string::npos) << secret;
        EXPECT_NE(said.find("name and id are kept in the case file"), std::string::npos);
    }

    TEST(HookOpening, IsTheDistanceBetweenOppositeHooks)
    {
        FieldMetrics field;
        field.hooks = { { .name = "left_1", .side = 1, .moved_mm = 30.0, .asked_mm = 30.0 },
            { .name = "left_2", .side = 1, .moved_mm = 20.0, .asked_mm = 30.0 },
            { .name = "right_1", .side = -1, .moved_mm = 10.0, .asked_mm = 30.0 } };
        EXPECT_EQ(hook_opening(field).asked_mm, 60.0);
        EXPECT_EQ(hook_opening(field).reached_mm, 35.0);
        EXPECT_EQ(asked_text(field), "60.0 mm");
        field.hooks[1].pull.force_limit_N = 150.0;
        EXPECT_EQ(asked_text(field), "60.0 mm, 1 hook at most 150.0 N");
        for (HookForce& hook : field.hooks)
            hook.pull = { .force_N = 40.0 };
        EXPECT_FALSE(hook_opening(field).asked_mm);
        EXPECT_EQ(hook_opening(field).reached_mm, 35.0);
        EXPECT_EQ(asked_text(field), "3 hooks pull with 40.0 N");
    }

} // namespace computation_test
} // namespace retractor::planner
