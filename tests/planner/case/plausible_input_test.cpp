#include "planner/case/plausible_input.h"

#include "mesh/base/error.h"
#include "planner/case/case_io.h"

#include <gtest/gtest.h>

#include <functional>
#include <string>
#include <vector>

namespace retractor::planner {
namespace plausible_input_test {

    /// An intercostal incision of 150 mm that two hooks open by 50 mm.
    Approach sample_approach()
    {
        Approach approach;
        approach.name = "sample";
        approach.template_name = "points";
        approach.incision = { Vec3(0.0, 0.0, 0.0), Vec3(0.0, 0.0, 150.0) };
        approach.directions = { Vec3::UnitY(), Vec3::UnitY() };
        approach.depth_mm = 40.0;
        approach.target = { .label = {}, .centre = Vec3(0.0, 90.0, 75.0), .radius_mm = 15.0 };
        for (const int side : { 1, -1 })
            approach.hooks.push_back({ .name = side > 0 ? "left" : "right",
                .side = side,
                .along_mm = 75.0,
                .depth_mm = 20.0,
                .direction = side * Vec3::UnitX(),
                .opening_mm = 25.0 });
        return approach;
    }

    Case sample_case()
    {
        Case sample;
        sample.labels = { .path = "labels.nrrd", .sha256 = std::string(64, 'a') };
        sample.label_table = { { 1, "spine", "bone", mesh::Role::wall }, { 2, "skin", "skin", mesh::Role::wall },
            { 3, "lung", "lung", mesh::Role::voxel } };
        add_approach(sample, sample_approach());
        return sample;
    }

    fem::Material& material_of(Case& changed, const std::string& name)
    {
        for (fem::Material& material : changed.materials)
            if (material.name == name)
                return material;
        throw InputError("there is no such material", name);
    }

    /// What a changed case is refused with, where it is written: "pointer: message"; empty when it is accepted.
    std::string refusal(const std::function<void(Case&)>& change)
    {
        Case changed = sample_case();
        change(changed);
        try {
            (void)case_to_json(changed);
        } catch (const InputError& error) {
            return error.where() + ": " + error.what();
        }
        return {};
    }

    /// Expects a refusal at this place that has these words.
    void expect_refused(
        const std::function<void(Case&)>& change, const std::string& pointer, const std::vector<std::string>& words)
    {
        const std::string text = refusal(change);
        EXPECT_TRUE(text.starts_with(pointer + ": ")) << text;
        for (const std::string& word : words)
            EXPECT_NE(text.find(word), std::string::npos) << word << " in: " << text;
        EXPECT_NE(text.find("accept_implausible"), std::string::npos) << text;
    }

    TEST(PlausibleInput, TheDefaultsAreAccepted)
    {
        EXPECT_EQ(refusal([](Case&) {}), "");
        EXPECT_TRUE(find_implausible(Case {}).empty());
    }

    TEST(PlausibleInput, AModulusInAnotherUnitIsRefusedWithTheUnit)
    {
        const auto with = [](const char* name, double modulus_MPa) {
            return [=](Case& c) { material_of(c, name).youngs_modulus_MPa = modulus_MPa; };
        };
        const std::string skin = "/materials/0/youngs_modulus_MPa";
        expect_refused(with("skin", 200.0), skin,
            { "the Young's modulus of skin is 200 MPa", "0.005 to 100 MPa", "is it in kPa (0.2 MPa)?" });
        expect_refused(with("bone", 10.0), "/materials/4/youngs_modulus_MPa", { "is it in GPa (10000 MPa)?" });
        expect_refused(with("skin", 2e5), skin, { "is it in Pa (0.2 MPa)?" });
        expect_refused(with("bone", 1e-9), "/materials/4/youngs_modulus_MPa", { "look at the number and its unit" });
        EXPECT_EQ(refusal(with("skin", 83.0)), "") << "skin in tension to failure";
        EXPECT_EQ(refusal(with("bone", 13500.0)), "") << "cortical bone";
    }

    TEST(PlausibleInput, EachDefaultModulusInKilopascalIsRefused)
    {
        for (const fem::Material& material : fem::default_materials()) {
            const std::string text = refusal(
                [&](Case& c) { material_of(c, material.name).youngs_modulus_MPa = 1e3 * material.youngs_modulus_MPa; });
            EXPECT_NE(text.find("is it in kPa"), std::string::npos) << material.name << ": " << text;
        }
    }

    TEST(PlausibleInput, ALawInAnotherUnitIsRefused)
    {
        const auto with = [](double c10) {
            return [=](Case& c) {
                material_of(c, "skin").law = fem::TissueLaw { fem::MooneyRivlin { .c10 = c10, .c01 = 0.0 } };
            };
        };
        EXPECT_EQ(refusal(with(0.03)), "");
        // Six times c10 is the Young's modulus: 1800 MPa.
        expect_refused(with(300.0), "/materials/0/law", { "is 1800 MPa", "is it in kPa (1.8 MPa)?" });
    }

    TEST(PlausibleInput, TensionAndPoissonsRatioOfNoTissueAreRefused)
    {
        const auto tension = [](double strain) {
            return [=](Case& c) {
                material_of(c, "skin").pre_strain
                    = { .kind = fem::PreStrainKind::equibiaxial, .strain = strain, .across = strain };
            };
        };
        EXPECT_EQ(refusal(tension(0.06)), "");
        expect_refused(tension(0.4), "/materials/0/pre_strain/along", { "the tension of skin is 0.4", "0 to 0.3" });
        expect_refused([](Case& c) { material_of(c, "skin").poissons_ratio = -0.2; }, "/materials/0/poissons_ratio",
            { "-0.2", "0 to 0.5" });
    }

    TEST(PlausibleInput, APressureInMillimetresOfMercuryIsRefused)
    {
        const auto pressure = [](double kPa) { return [=](Case& c) { c.pressures = { { "lung", kPa } }; }; };
        EXPECT_EQ(refusal(pressure(1.3)), "");
        EXPECT_EQ(refusal(pressure(-27.0)), "") << "a drain";
        expect_refused(pressure(120.0), "/pressures/0/pressure_kPa",
            { "the pressure of lung is 120 kPa", "is it in mmHg (15.9986 kPa)?" });
    }

    TEST(PlausibleInput, LengthsInMetresAreRefused)
    {
        const std::string pointer = "/approaches/0";
        expect_refused([](Case& c) { c.approaches[0].depth_mm = 0.04; }, pointer + "/depth_mm",
            { "the depth of the cut is 0.04 mm", "1 to 400 mm", "is it in m (40 mm)?" });
        expect_refused(
            [](Case& c) {
                Approach& a = c.approaches[0];
                a.incision[1] *= 1e-3;
                for (HookSpec& hook : a.hooks) {
                    hook.along_mm *= 1e-3;
                    hook.opening_mm *= 1e-3;
                }
            },
            pointer + "/incision_mm", { "is it in m (150 mm)?", "2 more number(s) are implausible" });
        expect_refused([](Case& c) { c.approaches[0].hooks[1].opening_mm = 0.025; }, pointer + "/hooks/1/opening_mm",
            { "the motion of the hook \"right\" is 0.025 mm", "is it in m (25 mm)?" });
        expect_refused([](Case& c) { c.approaches[0].view.eye_distance_mm = 0.4; }, pointer + "/view/eye_distance_mm",
            { "is it in m (400 mm)?" });
    }

    TEST(PlausibleInput, HooksPullWithForcesOfHands)
    {
        const auto pull = [](const HookPull& with) {
            return [=](Case& c) {
                HookSpec& hook = c.approaches[0].hooks[0];
                hook.pull = with;
                if (with.force_N)
                    hook.opening_mm = 0.0;
            };
        };
        const std::string hook = "/approaches/0/hooks/0/";
        EXPECT_EQ(refusal(pull({ .force_N = 470.0 })), "") << "the largest force measured on a thoracotomy";
        expect_refused(pull({ .force_N = 5000.0 }), hook + "force_N", { "0.01 to 1000 N", "is it in mN (5 N)?" });
        expect_refused(pull({ .force_limit_N = 5000.0 }), hook + "force_limit_N", { "the force limit" });
        expect_refused(pull({ .grip_N_per_mm = 5000.0 }), hook + "grip_N_per_mm", { "is it in N/m (5 N/mm)?" });
    }

    TEST(PlausibleInput, ACaseThatAcceptsItKeepsTheChoice)
    {
        Case odd = sample_case();
        material_of(odd, "skin").youngs_modulus_MPa = 200.0;
        EXPECT_THROW(check_plausible(odd), InputError);
        EXPECT_EQ(case_to_json(sample_case()).find("accept_implausible"), std::string::npos);
        odd.accept_implausible = true;
        EXPECT_NO_THROW(check_plausible(odd));
        const std::string text = case_to_json(odd);
        const Case back = case_from_json(text, {});
        EXPECT_TRUE(back.accept_implausible);
        EXPECT_EQ(case_to_json(back), text);
        ASSERT_EQ(find_implausible(back).size(), 1U);
        EXPECT_EQ(find_implausible(back)[0].pointer, "/materials/0/youngs_modulus_MPa");
    }

    TEST(PlausibleInput, AnApproachThatIsNotInTheCaseIsCheckedToo)
    {
        Approach approach = sample_approach();
        approach.depth_mm = 0.04;
        Case accepting;
        EXPECT_THROW(check_plausible(accepting, approach), InputError);
        accepting.accept_implausible = true;
        EXPECT_NO_THROW(check_plausible(accepting, approach));
    }

    TEST(PlausibleInput, ImagesOfNoPatientAreFoundByTheirLongestSide)
    {
        mesh::ImageGrid grid;
        grid.size = { 512, 512, 300 };
        grid.spacing = Vec3(0.7, 0.7, 1.0);
        EXPECT_FALSE(implausible_extent(grid).has_value());
        const auto scaled = [&](double scale) {
            mesh::ImageGrid other = grid;
            other.spacing *= scale;
            return implausible_extent(other).value_or("");
        };
        EXPECT_NE(scaled(1e-3).find("is it in m (358.4 mm)?"), std::string::npos) << scaled(1e-3);
        EXPECT_NE(scaled(0.1).find("is it in cm (358.4 mm)?"), std::string::npos) << scaled(0.1);
        EXPECT_NE(scaled(1e3).find("is it in µm (358.4 mm)?"), std::string::npos) << scaled(1e3);
    }

} // namespace plausible_input_test
} // namespace retractor::planner
