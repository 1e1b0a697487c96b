#include "planner/case/case_io.h"

#include "mesh/base/error.h"
#include "planner/approach/hooks.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <functional>
#include <limits>

namespace retractor::planner {
namespace case_io_test {

    namespace fs = std::filesystem;
    using Json = nlohmann::ordered_json;

    /// A folder of its own per test, removed at the end.
    class CaseFile : public ::testing::Test {
    protected:
        void SetUp() override
        {
            folder_ = fs::temp_directory_path()
                / ("retractor_case_" + std::string(::testing::UnitTest::GetInstance()->current_test_info()->name()));
            fs::remove_all(folder_);
            fs::create_directories(folder_ / "ct");
            put("labels.nrrd", "labels");
            put("ct/1.dcm", "one");
            put("ct/2.dcm", "two");
        }
        void TearDown() override { fs::remove_all(folder_); }
        void put(const std::string& name, const std::string& text) const { std::ofstream(folder_ / name) << text; }

        Approach approach(const std::string& name) const
        {
            Approach a;
            a.name = name;
            a.template_name = "points";
            for (int n = 0; n < 12; ++n) { // numbers with no short decimal form
                a.incision.emplace_back(std::sqrt(2.0) * n, 9.0 * n + 1.0 / 3.0, -0.1 * n);
                a.directions.push_back(Vec3(0.1 * std::sqrt(n), -0.2, -1.0).normalized());
                a.wall_thickness_mm.push_back(30.0 + 0.1 * n);
                a.hook_depth_mm.push_back(17.0 / 1.1);
            }
            a.depth_mm = 37.0 / 0.9;
            a.target.label = "aneurysm";
            a.retracted = { "lung" };
            a.uncut_labels = { "rib" };
            a.ablations = { { .label = "rib", .from_mm = -10.0 / 3.0, .to_mm = 0.1 },
                { .label = "rib", .from_mm = 1.0, .to_mm = 2.0, .along_from_mm = 7.0 / 3.0, .along_to_mm = 50.1 },
                { .centre = Vec3(0.1, -1e-17, 3.3), .radius_mm = 4.0 / 3.0 } };
            a.division = { .extent = DivisionExtent::full, .forwards_mm = 100.0 / 3.0 };
            a.opening_protocol
                = OpeningProtocol { .turn_mm = 40.0 / 3.0, .turns_per_step = 1.0, .wait_s = 20.1, .hold_s = 600.0 };
            a.loose_pieces = LoosePieces::rigid;
            a.sizing.region_mm = 80.1;
            a.view.half_angle_deg = 17.3;
            a.title = "Médiane, longue";
            a.rationale = "because \"it\" is so: größer\n";
            a.hooks = make_hooks(a, "4", 1e2 / 3.0);
            return a;
        }
        Case sample() const
        {
            Case c;
            c.folder = folder_;
            c.ct = make_reference(folder_, folder_ / "ct");
            c.labels = make_reference(folder_, folder_ / "labels.nrrd");
            c.label_table = { { 1, "spine", "bone", mesh::Role::wall }, { 2, "rib", "bone", mesh::Role::wall },
                { 3, "lung", "lung", mesh::Role::voxel }, { 700, "aneurysm", "vessel", mesh::Role::target },
                { 9, "heart", "heart", mesh::Role::at_risk } };
            add_approach(c, approach("first"));
            Approach second = approach("second");
            second.target = { .label = {}, .centre = Vec3(0.1, -1e-17, 1e3 / 7.0), .radius_mm = 0.3 };
            second.hooks.clear();
            add_approach(c, second);
            Approach third = approach("third");
            third.target
                = { .label = "heart", .centre = Vec3(1.0, 2.0, -3.0), .radius_mm = 8.0, .site = "anastomosis site" };
            add_approach(c, third);
            return c;
        }

        /// The pointer a damaged case is refused with.
        std::string refused_at(const std::function<void(Json&)>& damage) const
        {
            Json json = Json::parse(case_to_json(sample()));
            damage(json);
            return refused_text(json.dump());
        }
        std::string refused_text(const std::string& text) const
        {
            try {
                case_from_json(text, folder_);
            } catch (const InputError& error) {
                return error.where();
            }
            return "accepted";
        }

        fs::path folder_;
    };

    void expect_equal(const Approach& a, const Approach& b)
    {
        EXPECT_EQ(a.name, b.name);
        EXPECT_EQ(a.template_name, b.template_name);
        EXPECT_EQ(a.incision, b.incision);
        EXPECT_EQ(a.directions, b.directions);
        EXPECT_EQ(a.depth_mm, b.depth_mm);
        EXPECT_EQ(a.wall_thickness_mm, b.wall_thickness_mm);
        EXPECT_EQ(a.hook_depth_mm, b.hook_depth_mm);
        EXPECT_EQ(a.target.label, b.target.label);
        EXPECT_EQ(a.target.centre, b.target.centre);
        EXPECT_EQ(a.target.radius_mm, b.target.radius_mm);
        EXPECT_EQ(a.target.site, b.target.site);
        EXPECT_EQ(a.retracted, b.retracted);
        EXPECT_EQ(a.uncut_labels, b.uncut_labels);
        EXPECT_EQ(a.loose_pieces, b.loose_pieces);
        EXPECT_EQ(a.division.extent, b.division.extent);
        EXPECT_EQ(a.division.forwards_mm, b.division.forwards_mm);
        EXPECT_EQ(a.division.backwards_mm, b.division.backwards_mm);
        EXPECT_EQ(a.opening_protocol, b.opening_protocol);
        ASSERT_EQ(a.ablations.size(), b.ablations.size());
        for (std::size_t n = 0; n < a.ablations.size(); ++n) {
            EXPECT_EQ(a.ablations[n].label, b.ablations[n].label);
            EXPECT_EQ(a.ablations[n].from_mm, b.ablations[n].from_mm);
            EXPECT_EQ(a.ablations[n].to_mm, b.ablations[n].to_mm);
            EXPECT_EQ(a.ablations[n].along_from_mm, b.ablations[n].along_from_mm);
            EXPECT_EQ(a.ablations[n].along_to_mm, b.ablations[n].along_to_mm);
            EXPECT_EQ(a.ablations[n].centre, b.ablations[n].centre);
            EXPECT_EQ(a.ablations[n].radius_mm, b.ablations[n].radius_mm);
        }
        EXPECT_EQ(a.sizing.region_mm, b.sizing.region_mm);
        EXPECT_EQ(a.view.half_angle_deg, b.view.half_angle_deg);
        EXPECT_EQ(a.view.eye_count, b.view.eye_count);
        EXPECT_EQ(a.title, b.title);
        EXPECT_EQ(a.rationale, b.rationale);
        ASSERT_EQ(a.hooks.size(), b.hooks.size());
        for (std::size_t h = 0; h < a.hooks.size(); ++h) {
            EXPECT_EQ(a.hooks[h].name, b.hooks[h].name);
            EXPECT_EQ(a.hooks[h].side, b.hooks[h].side);
            EXPECT_EQ(a.hooks[h].along_mm, b.hooks[h].along_mm);
            EXPECT_EQ(a.hooks[h].depth_mm, b.hooks[h].depth_mm);
            EXPECT_EQ(a.hooks[h].direction, b.hooks[h].direction);
            EXPECT_EQ(a.hooks[h].opening_mm, b.hooks[h].opening_mm);
        }
    }

    TEST_F(CaseFile, HowWoundsAreSolvedComesBackAndIsTheDefaultWhereItIsNotSaid)
    {
        Case c = sample();
        EXPECT_EQ(case_to_json(c).find("solution"), std::string::npos);
        EXPECT_EQ(case_from_json(case_to_json(c), folder_).solution, SolverSettings {});
        c.solution = { fem::Elasticity::hyperelastic, ElementKind::p2, 100.0 / 3.0 };
        EXPECT_EQ(case_from_json(case_to_json(c), folder_).solution, c.solution);
        c.contact = ContactMode::always;
        EXPECT_THROW((void)case_to_json(c), InputError); // near, contact
        EXPECT_EQ(refused_at([](Json& j) { j["solution"] = { { "elasticity", "rubber" } }; }), "/solution/elasticity");
        EXPECT_EQ(refused_at([](Json& j) { j["solution"] = { { "element", "p3" } }; }), "/solution/element");
        EXPECT_EQ(refused_at([](Json& j) { j["solution"] = { { "near_mm", -1.0 } }; }), "/solution/near_mm");
        EXPECT_EQ(refused_at([](Json& j) { j["solution"] = { { "radius_mm", 1.0 } }; }), "/solution/radius_mm");
        EXPECT_EQ(refused_at([](Json& j) {
            j["solution"] = { { "elasticity", "linear" }, { "near_mm", 10.0 } };
        }),
            "/solution");
    }

    TEST_F(CaseFile, AssumedVesselsComeBackAndBadOnesAreRefused)
    {
        Case c = sample();
        c.assumed_vessels = { { .name = "mammary_artery_left",
            .line = { Vec3(0.1, 1e2 / 3.0, -1e-17), Vec3::UnitX(), Vec3::UnitZ() },
            .radius_mm = 1.0 / 0.9 } };
        const Case read = case_from_json(case_to_json(c), folder_);
        ASSERT_EQ(read.assumed_vessels.size(), 1U);
        EXPECT_EQ(read.assumed_vessels[0].name, c.assumed_vessels[0].name);
        EXPECT_EQ(read.assumed_vessels[0].line, c.assumed_vessels[0].line);
        EXPECT_EQ(read.assumed_vessels[0].radius_mm, c.assumed_vessels[0].radius_mm);
        const std::string at = "/assumed_vessels/0";
        const auto refused = [&](const char* key, const Json& value) {
            return refused_at([&](Json& j) {
                Json vessel = { { "name", "a" }, { "line_mm", { { 0.0, 0.0, 0.0 }, { 1.0, 0.0, 0.0 } } },
                    { "radius_mm", 1.0 } };
                vessel[key] = value;
                j["assumed_vessels"] = Json::array({ vessel });
            });
        };
        EXPECT_EQ(refused("name", "b"), "accepted");
        EXPECT_EQ(refused("name", ""), at + "/name");
        EXPECT_EQ(refused("name", "heart"), at + "/name") << "a label";
        EXPECT_EQ(refused("line_mm", Json::array({ { 0.0, 0.0, 0.0 } })), at + "/line_mm");
        EXPECT_EQ(refused("line_mm", { { 0.0, 0.0, 0.0 }, { 0.0, nullptr, 0.0 } }), at + "/line_mm/1/1");
        for (const double radius : { 0.0, -1.0, 26.0 })
            EXPECT_EQ(refused("radius_mm", radius), at + "/radius_mm") << radius;
        EXPECT_EQ(refused("colour", "red"), at + "/colour");
        EXPECT_EQ(refused_at([](Json& j) {
            const Json vessel
                = { { "name", "a" }, { "line_mm", { { 0.0, 0.0, 0.0 }, { 1.0, 0.0, 0.0 } } }, { "radius_mm", 1.0 } };
            j["assumed_vessels"] = Json::array({ vessel, vessel });
        }),
            "/assumed_vessels/1/name")
            << "two of one name";
    }

    TEST_F(CaseFile, AnAskedAccuracyComesBackAndIsRefusedOutOfRange)
    {
        Case c = sample();
        c.solution.accuracy = AccuracyGoal { .force = 1.0 / 3.0, .opening_mm = 10.0 / 3.0, .time_s = 1e3 / 7.0 };
        EXPECT_EQ(case_from_json(case_to_json(c), folder_).solution, c.solution);
        const auto read = [&](const Json& accuracy) {
            Json json = Json::parse(case_to_json(sample()));
            json["solution"] = { { "accuracy", accuracy } };
            return case_from_json(json.dump(), folder_).solution.accuracy;
        };
        EXPECT_EQ(read(Json::object()), AccuracyGoal {});
        EXPECT_EQ(read({ { "force", 0.1 } }), (AccuracyGoal { .force = 0.1 }));
        EXPECT_EQ(read({ { "opening", 1.0 }, { "time", 60.0 } }), (AccuracyGoal { .opening_mm = 1.0, .time_s = 60.0 }));
        const auto refused = [&](const char* key, const Json& value) {
            return refused_at([&](Json& j) { j["solution"] = { { "accuracy", { { key, value } } } }; });
        };
        const std::string at = "/solution/accuracy";
        for (const double force : { 0.0049, 1.01, 15.0, 0.0, -0.1 })
            EXPECT_EQ(refused("force", force), at + "/force") << force;
        for (const double opening : { 0.09, 20.1, -1.0 })
            EXPECT_EQ(refused("opening", opening), at + "/opening") << opening;
        for (const double time : { 0.0, 0.9, 86'401.0 })
            EXPECT_EQ(refused("time", time), at + "/time") << time;
        for (const double force : { 0.005, 1.0 })
            EXPECT_EQ(refused("force", force), "accepted") << force;
        EXPECT_EQ(refused("force", "15%"), at + "/force");
        EXPECT_EQ(refused("rounds", 3), at + "/rounds");
        EXPECT_EQ(refused_at([](Json& j) { j["solution"] = { { "accuracy", "none" } }; }), at);
        c.solution.accuracy->force = std::numeric_limits<double>::quiet_NaN();
        EXPECT_THROW((void)case_to_json(c), InputError);
    }

    TEST_F(CaseFile, RefusesAnOpeningProtocolThatIsIncompleteOrOutOfRange)
    {
        const auto protocol_refused_at = [&](const std::string& key, const Json& value) {
            return refused_at([&](Json& j) { j["approaches"][0]["opening_protocol"][key] = value; });
        };
        const std::string at = "/approaches/0/opening_protocol";
        EXPECT_EQ(protocol_refused_at("turn_mm", 0.0), at + "/turn_mm");
        EXPECT_EQ(protocol_refused_at("turns_per_step", -0.5), at + "/turns_per_step");
        EXPECT_EQ(protocol_refused_at("wait_s", "slow"), at + "/wait_s");
        EXPECT_EQ(protocol_refused_at("hold_s", nullptr), at + "/hold_s"); // how NaN is written
        EXPECT_EQ(protocol_refused_at("speed", 1.0), at + "/speed");
        EXPECT_EQ(refused_at([](Json& j) { j["approaches"][0]["opening_protocol"].erase("wait_s"); }), at + "/wait_s");
    }

    TEST_F(CaseFile, TheRemovedSubmodelIsRefusedWithWhatReplacesIt)
    {
        Json json = Json::parse(case_to_json(sample()));
        json["solution"] = { { "local", 60.0 } };
        try {
            (void)case_from_json(json.dump(), folder_);
            FAIL() << "a submodel was accepted";
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), "/solution/local");
            EXPECT_NE(std::string(error.what()).find("the submodel was removed"), std::string::npos) << error.what();
            EXPECT_NE(std::string(error.what()).find("near_mm does it right"), std::string::npos) << error.what();
        }
    }

    TEST_F(CaseFile, LawsOfMaterialsComeBackAndBadOnesAreRefused)
    {
        Case c = sample();
        c.materials[0].law = fem::TissueLaw { fem::MooneyRivlin { .c10 = 0.1 / 3.0, .c01 = 0.01 } };
        c.materials[1].law
            = fem::TissueLaw { fem::HolzapfelGasserOgden { .mu = 0.003, .k1 = 0.002, .k2 = 1.7, .dispersion = 0.1 },
                  { .first = Vec3(1.0, 2.0, 0.0).normalized(), .second = Vec3::UnitZ() } };
        c.materials[2].law = fem::TissueLaw { fem::Guccione { .C = 0.002, .bf = 8.0, .bt = 2.0, .bfs = 4.0 },
            { .first = Vec3::UnitY(), .second = Vec3::UnitY() } };
        const Case back = case_from_json(case_to_json(c), folder_);
        EXPECT_EQ(std::get<fem::MooneyRivlin>(back.materials[0].law->law).c10, 0.1 / 3.0);
        EXPECT_EQ(std::get<fem::HolzapfelGasserOgden>(back.materials[1].law->law).k2, 1.7);
        EXPECT_LT((back.materials[1].law->fibres.first - c.materials[1].law->fibres.first).norm(), 1e-15);
        EXPECT_EQ(back.materials[1].law->fibres.second, Vec3::UnitZ());
        EXPECT_EQ(std::get<fem::Guccione>(back.materials[2].law->law).bfs, 4.0);
        EXPECT_EQ(back.materials[2].law->fibres.first, Vec3::UnitY());
        EXPECT_FALSE(back.materials[3].law.has_value());
        const fem::FibresAround around {
            .point = Vec3(1.0, 2.0 / 3.0, 3.0), .axis = Vec3(0.0, 0.1, 1.0), .angle_deg = 37.5
        };
        for (const std::size_t i : { 1U, 2U }) {
            c.materials[i].law->around = around;
            const std::optional<fem::FibresAround> again
                = case_from_json(case_to_json(c), folder_).materials[i].law->around;
            ASSERT_TRUE(again.has_value());
            EXPECT_EQ(again->point, around.point);
            EXPECT_EQ(again->axis, around.axis);
            EXPECT_EQ(again->angle_deg, around.angle_deg);
        }
        const auto law_refused_at
            = [&](const Json& law) { return refused_at([&](Json& j) { j["materials"][0]["law"] = law; }); };
        EXPECT_EQ(law_refused_at({ { "model", "ogden" } }), "/materials/0/law/model");
        EXPECT_EQ(law_refused_at({ { "model", "mooney-rivlin" }, { "c10_MPa", 1.0 } }), "/materials/0/law/c01_MPa");
        EXPECT_EQ(law_refused_at({ { "model", "mooney-rivlin" }, { "c10_MPa", -1.0 }, { "c01_MPa", 0.5 } }),
            "/materials/0/law");
        EXPECT_EQ(
            law_refused_at({ { "model", "mooney-rivlin" }, { "c10_MPa", 1.0 }, { "c01_MPa", 0.5 }, { "bf", 1.0 } }),
            "/materials/0/law/bf");
        EXPECT_EQ(law_refused_at({ { "model", "guccione" }, { "C_MPa", 1.0 }, { "bf", 1.0 }, { "bt", 1.0 },
                      { "bfs", 1.0 }, { "fibres", Json::array({ Json::array({ 0.0, 0.0, 0.0 }) }) } }),
            "/materials/0/law/fibres");
        const Json fibres { { "around", { { "point_mm", { 0.0, 0.0, 0.0 } }, { "axis", { 0.0, 0.0, 1.0 } } } },
            { "angle_deg", 40.0 } };
        const auto fibres_refused_at = [&](const std::string& changed, const Json& value) {
            Json bad = fibres;
            bad[Json::json_pointer(changed)] = value;
            std::string place = law_refused_at({ { "model", "guccione" }, { "C_MPa", 1.0 }, { "bf", 1.0 },
                { "bt", 1.0 }, { "bfs", 1.0 }, { "fibres", bad } });
            const std::string all = "/materials/0/law/fibres";
            return place.starts_with(all) ? place.substr(all.size()) : "elsewhere: " + place;
        };
        EXPECT_EQ(fibres_refused_at("/around/axis", { 0.0, 0.0, 0.0 }), "");
        EXPECT_EQ(fibres_refused_at("/angle_deg", 100.0), "");
        EXPECT_EQ(fibres_refused_at("/angle_deg", -1.0), "");
        EXPECT_EQ(fibres_refused_at("/angle_deg", nullptr), "/angle_deg"); // how NaN is written
        EXPECT_EQ(fibres_refused_at("/around/axis", { 0.0, 1.0 }), "/around/axis");
        EXPECT_EQ(fibres_refused_at("/around/axis", { 0.0, nullptr, 1.0 }), "/around/axis/1");
        EXPECT_EQ(fibres_refused_at("/around/point_mm", "heart"), "/around/point_mm");
        EXPECT_EQ(fibres_refused_at("/around", { { "axis", { 0.0, 0.0, 1.0 } } }), "/around/point_mm");
        EXPECT_EQ(fibres_refused_at("/directions", Json::array({ { 0.0, 0.0, 1.0 } })), "/directions"); // one or other
        EXPECT_EQ(law_refused_at(
                      { { "model", "mooney-rivlin" }, { "c10_MPa", 1.0 }, { "c01_MPa", 0.5 }, { "fibres", fibres } }),
            "/materials/0/law/fibres"); // a law without
    }

    TEST_F(CaseFile, TensionOfMaterialsComesBackAndBadOneIsRefused)
    {
        Case c = sample();
        c.materials[0].pre_strain
            = { fem::PreStrainKind::biaxial, 0.1 / 3.0, Vec3(0.0, 0.1, 2.0), Vec3(0.3, -1.0, 0.0), 0.01 };
        c.materials[1].pre_strain = { fem::PreStrainKind::uniaxial_stress, 0.05, Vec3::UnitX() };
        c.materials[2].pre_strain = { .kind = fem::PreStrainKind::equibiaxial, .strain = 0.02 };
        const Case back = case_from_json(case_to_json(c), folder_);
        EXPECT_EQ(back.materials[0].pre_strain.kind, fem::PreStrainKind::biaxial);
        EXPECT_EQ(back.materials[0].pre_strain.strain, 0.1 / 3.0);
        EXPECT_EQ(back.materials[0].pre_strain.across, 0.01);
        EXPECT_EQ(back.materials[0].pre_strain.pull, Vec3(0.0, 0.1, 2.0));
        EXPECT_EQ(back.materials[0].pre_strain.normal, Vec3(0.3, -1.0, 0.0));
        EXPECT_EQ(back.materials[1].pre_strain.kind, fem::PreStrainKind::uniaxial_stress);
        EXPECT_EQ(back.materials[2].pre_strain.across, 0.02) << "the same both ways";
        EXPECT_EQ(back.materials[3].pre_strain.kind, fem::PreStrainKind::none);
        EXPECT_EQ(case_to_json(back), case_to_json(case_from_json(case_to_json(back), folder_)));
        const auto refused = [&](const Json& tension) {
            return refused_at([&](Json& j) { j["materials"][0]["pre_strain"] = tension; });
        };
        const Json up = Json::array({ 0.0, 0.0, 1.0 }), nowhere = Json::array({ 0.0, 0.0, 0.0 });
        const std::string at = "/materials/0/pre_strain";
        EXPECT_EQ(refused({ { "across", 0.1 } }), at + "/along");
        EXPECT_EQ(refused({ { "along", 0.7 }, { "direction", up } }), at + "/along");
        EXPECT_EQ(refused({ { "along", -0.1 }, { "direction", up } }), at + "/along");
        EXPECT_EQ(refused({ { "along", 0.1 }, { "across", 0.6 }, { "direction", up } }), at + "/across");
        EXPECT_EQ(refused({ { "along", nullptr }, { "direction", up } }), at + "/along");
        EXPECT_EQ(refused({ { "along", 0.1 } }), at + "/direction") << "which way?";
        EXPECT_EQ(refused({ { "along", 0.1 }, { "across", 0.2 } }), at + "/direction");
        EXPECT_EQ(refused({ { "along", 0.1 }, { "direction", nowhere } }), at + "/direction");
        EXPECT_EQ(refused({ { "along", 0.1 }, { "direction", up }, { "normal", nowhere } }), at + "/normal");
        EXPECT_EQ(refused({ { "along", 0.1 }, { "direction", up }, { "normal", up } }), at + "/normal");
        EXPECT_EQ(refused({ { "along", 0.1 }, { "angle", 3.0 } }), at + "/angle");
        c.materials[0].pre_strain.across = std::numeric_limits<double>::quiet_NaN();
        try {
            check_case(c);
            FAIL() << "NaN";
        } catch (const InputError& error) {
            EXPECT_EQ(error.where(), at + "/across");
            EXPECT_NE(std::string(error.what()).find(c.materials[0].name), std::string::npos) << error.what();
        }
        c.materials[0].pre_strain = { .kind = fem::PreStrainKind::isotropic, .strain = 0.02 };
        EXPECT_THROW((void)case_to_json(c), InputError);
    }

    TEST_F(CaseFile, ChecksumIsSha256)
    {
        put("abc", "abc"); // FIPS 180-4, example 1
        EXPECT_EQ(checksum(folder_ / "abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
        const std::string before = checksum(folder_ / "ct");
        EXPECT_EQ(before, checksum(folder_ / "ct"));
        fs::rename(folder_ / "ct/2.dcm", folder_ / "ct/3.dcm"); // a folder's names count too
        EXPECT_NE(before, checksum(folder_ / "ct"));
        EXPECT_THROW(checksum(folder_ / "missing"), IoError);
    }

    TEST_F(CaseFile, ComesBackToTheLastBit)
    {
        const Case written = sample();
        write_case(written);
        for (const fs::path& path : { folder_, folder_ / "case.json" }) {
            const Case read = read_case(path);
            EXPECT_EQ(read.labels.path, written.labels.path);
            EXPECT_EQ(read.labels.sha256, written.labels.sha256);
            ASSERT_TRUE(read.ct);
            EXPECT_EQ(read.ct->sha256, written.ct->sha256);
            EXPECT_TRUE(fs::equivalent(read.labels_path(), folder_ / "labels.nrrd"));
            ASSERT_EQ(read.label_table.size(), written.label_table.size());
            for (std::size_t n = 0; n < read.label_table.size(); ++n) {
                EXPECT_EQ(read.label_table[n].id, written.label_table[n].id);
                EXPECT_EQ(read.label_table[n].name, written.label_table[n].name);
                EXPECT_EQ(read.label_table[n].material, written.label_table[n].material);
                EXPECT_EQ(read.label_table[n].role, written.label_table[n].role);
            }
            ASSERT_EQ(read.materials.size(), written.materials.size());
            for (std::size_t n = 0; n < read.materials.size(); ++n) {
                EXPECT_EQ(read.materials[n].name, written.materials[n].name);
                EXPECT_EQ(read.materials[n].youngs_modulus_MPa, written.materials[n].youngs_modulus_MPa);
                EXPECT_EQ(read.materials[n].density_tonne_per_mm3, written.materials[n].density_tonne_per_mm3);
                EXPECT_EQ(read.materials[n].source, written.materials[n].source);
            }
            EXPECT_EQ(read.supports.labels, written.supports.labels);
            EXPECT_EQ(read.views, written.views);
            ASSERT_EQ(read.approaches.size(), 3u);
            expect_equal(read.approaches[0], written.approaches[0]);
            expect_equal(read.approaches[1], written.approaches[1]);
            EXPECT_EQ(case_to_json(read), case_to_json(written));
        }
    }

    TEST_F(CaseFile, CaseWithoutCtOrApproachesIsACase)
    {
        Case bare = sample();
        bare.ct.reset();
        bare.approaches.clear();
        write_case(bare);
        EXPECT_FALSE(read_case(folder_).ct);
        EXPECT_TRUE(read_case(folder_).approaches.empty());
    }

    TEST_F(CaseFile, ContactIsAutomaticWhereTheFileDoesNotSay)
    {
        Case c = sample();
        EXPECT_EQ(case_to_json(c).find("contact"), std::string::npos);
        EXPECT_EQ(case_from_json(case_to_json(c), folder_).contact, ContactMode::automatic);
        for (const auto& [contact, text] : { std::pair(ContactMode::always, "\"contact\": true"),
                 std::pair(ContactMode::never, "\"contact\": false") }) {
            c.contact = contact;
            EXPECT_NE(case_to_json(c).find(text), std::string::npos);
            EXPECT_EQ(case_from_json(case_to_json(c), folder_).contact, contact);
        }
        EXPECT_EQ(refused_at([](Json& j) { j["contact"] = "automatic"; }), "/contact");
        EXPECT_EQ(refused_at([](Json& j) { j["contact"] = 1; }), "/contact");
        EXPECT_EQ(refused_at([](Json& j) { j["contact"] = "auto"; }), "accepted");
    }

    TEST_F(CaseFile, EstimatedLabelsComeBackAndMustBeInTheTable)
    {
        Case c = sample();
        EXPECT_EQ(case_to_json(c).find("estimated"), std::string::npos);
        const std::string name = c.label_table.front().name;
        c.estimated_labels = { name };
        const Case again = case_from_json(case_to_json(c), folder_);
        EXPECT_EQ(again.estimated_labels, c.estimated_labels);
        EXPECT_TRUE(is_estimated(again, name));
        EXPECT_FALSE(is_estimated(again, c.label_table.back().name));
        EXPECT_EQ(refused_at([](Json& j) { j["labels"]["estimated"] = { "nobody" }; }), "/labels/estimated/0");
        EXPECT_EQ(refused_at([](Json& j) { j["labels"]["estimated"] = true; }), "/labels/estimated");
    }

    TEST_F(CaseFile, HasTheNameItIsGiven)
    {
        Case second = sample();
        second.file_name = "second.json";
        write_case(second);
        EXPECT_FALSE(fs::exists(folder_ / "case.json"));
        Case read = read_case(folder_ / "second.json");
        EXPECT_EQ(read.file(), folder_ / "second.json");
        read.approaches.clear();
        write_case(read); // goes back where it came from
        EXPECT_TRUE(read_case(folder_ / "second.json").approaches.empty());
        EXPECT_FALSE(fs::exists(folder_ / "case.json"));
        EXPECT_THROW((void)read_case(folder_), IoError) << "a folder stands for the case.json in it";
    }

    /// A case as the first version of the format had it: all keys are there that it had, and no other.
    constexpr const char* kFirstCase = R"({
        "schema": 1, "frame": "LPS",
        "units": { "length": "mm", "force": "N", "stress": "MPa", "mass": "tonne", "angle": "deg" },
        "labels": { "path": "labels.nrrd",
            "sha256": "d772ebb4590212c65cc31888ee55c3a893d866d8479f84a4c0ca36918a3fa75f",
            "table": [ { "id": 1, "name": "spine", "material": "bone", "role": "wall" },
                { "id": 7, "name": "aneurysm", "material": "vessel", "role": "target" } ] },
        "materials": [ { "name": "bone", "youngs_modulus_MPa": 500.0, "poissons_ratio": 0.3,
                "density_tonne_per_mm3": 1.9e-9, "source": "an example" },
            { "name": "vessel", "youngs_modulus_MPa": 0.5, "poissons_ratio": 0.45,
                "density_tonne_per_mm3": 1.1e-9, "source": "an example" } ],
        "supports": { "labels": [ "spine" ], "region_border": true },
        "sizing": { "corridor_radius_mm": 20.0, "corridor_edge_mm": 2.5, "coarse_edge_mm": 8.0, "region_mm": 80.0 },
        "approaches": [ { "name": "median", "template": "points", "incision_mm": [ [ 0, 0, 0 ], [ 0, 0, 60 ] ],
            "directions": [ [ 0, 1, 0 ], [ 0, 1, 0 ] ], "depth_mm": 30.0, "wall_thickness_mm": [ 30.0, 30.0 ],
            "hook_depth_mm": [ 15.0, 15.0 ], "target": { "label": "aneurysm" },
            "hooks": [ { "name": "left 1", "side": 1, "along_mm": 30.0, "depth_mm": 15.0, "patch_width_mm": 10.0,
                "patch_height_mm": 8.0, "direction": [ 1, 0, 0 ], "opening_mm": 20.0 } ],
            "retracted": [], "uncut_labels": [],
            "sizing": { "corridor_radius_mm": 20.0, "corridor_edge_mm": 2.5, "coarse_edge_mm": 8.0,
                "region_mm": 80.0 },
            "view": { "eye_distance_mm": 400.0, "half_angle_deg": 20.0, "eye_count": 50 }, "rationale": "" } ],
        "views": [ "surgeon", "overview", "slices" ] })";

    TEST_F(CaseFile, OfTheFirstVersionIsReadAndMeansWhatItMeant)
    {
        put("case.json", kFirstCase);
        const Case read = read_case(folder_);
        // What came later is as if it were not there.
        EXPECT_FALSE(read.patient || read.ct);
        EXPECT_EQ(read.contact, ContactMode::automatic);
        EXPECT_TRUE(read.pressures.empty());
        EXPECT_EQ(read.solution, SolverSettings {});
        ASSERT_EQ(read.approaches.size(), 1U);
        EXPECT_TRUE(read.approaches[0].ablations.empty());
        EXPECT_EQ(read.approaches[0].loose_pieces, LoosePieces::held);
        EXPECT_EQ(read.approaches[0].division.extent, DivisionExtent::skin);
        EXPECT_FALSE(read.approaches[0].opening_protocol);
        EXPECT_TRUE(read.approaches[0].hooks.at(0).pull.prescribes());
        for (const fem::Material& material : read.materials) {
            EXPECT_FALSE(material.law) << material.name;
            EXPECT_EQ(material.pre_strain.kind, fem::PreStrainKind::none) << material.name;
        }
        // Written again, it has the same keys.
        EXPECT_EQ(nlohmann::json::parse(case_to_json(read)), nlohmann::json::parse(kFirstCase));
    }

    TEST_F(CaseFile, OfAnotherSchemaSaysWhichItHasAndWhichIsRead)
    {
        for (const int schema : { kCaseSchema - 1, kCaseSchema + 1 }) {
            Json json = Json::parse(case_to_json(sample()));
            json["schema"] = schema;
            json["a_key_of_that_schema"] = true;
            json.erase("views");
            try {
                (void)case_from_json(json.dump(), folder_);
                ADD_FAILURE() << "schema " << schema << " was accepted";
            } catch (const InputError& error) {
                EXPECT_EQ(error.where(), "/schema");
                EXPECT_EQ(std::string(error.what()),
                    "the case has schema " + std::to_string(schema) + ", written by "
                        + (schema < kCaseSchema ? "an older" : "a newer") + " program; this program reads schema "
                        + std::to_string(kCaseSchema));
            }
        }
    }

    TEST_F(CaseFile, EachDamageIsNamedByItsPointer)
    {
        const double nan = std::numeric_limits<double>::quiet_NaN(); // written as null
        const std::vector<std::pair<std::string, std::function<void(Json&)>>> damages {
            { "/schema", [](Json& j) { j["schema"] = 2; } },
            { "/schema", [](Json& j) { j.erase("schema"); } },
            { "/frame", [](Json& j) { j["frame"] = "RAS"; } },
            { "/units/length", [](Json& j) { j["units"]["length"] = "m"; } },
            { "/colour", [](Json& j) { j["colour"] = "red"; } },
            { "/a~1b~0", [](Json& j) { j["a/b~"] = 1; } },
            { "/labels/sha256", [](Json& j) { j["labels"]["sha256"] = "abc"; } },
            { "/labels/path", [](Json& j) { j["labels"]["path"] = "/etc/passwd"; } },
            { "/labels/path", [](Json& j) { j["labels"]["path"] = "a/../../labels.nrrd"; } },
            { "/ct/path", [](Json& j) { j["ct"]["path"] = 7; } },
            { "/labels/table/0/id", [](Json& j) { j["labels"]["table"][0]["id"] = 0; } },
            { "/labels/table/0/id", [](Json& j) { j["labels"]["table"][0]["id"] = 65536; } },
            { "/labels/table/0/id", [](Json& j) { j["labels"]["table"][0]["id"] = 1.5; } },
            { "/labels/table/1/id", [](Json& j) { j["labels"]["table"][1]["id"] = 1; } },
            { "/labels/table/1/name", [](Json& j) { j["labels"]["table"][1]["name"] = "spine"; } },
            { "/labels/table/2/role", [](Json& j) { j["labels"]["table"][2]["role"] = "wal"; } },
            { "/labels/table/0/material", [](Json& j) { j["labels"]["table"][0]["material"] = "chalk"; } },
            { "/materials/0/youngs_modulus_MPa", [](Json& j) { j["materials"][0]["youngs_modulus_MPa"] = 0.0; } },
            { "/materials/0/youngs_modulus_MPa",
                [](Json& j) { j["materials"][0]["youngs_modulus_MPa"] = 5000.0; } }, // skin as hard as bone
            { "/materials/0/youngs_modulus_MPa", [nan](Json& j) { j["materials"][0]["youngs_modulus_MPa"] = nan; } },
            { "/materials/1/poissons_ratio", [](Json& j) { j["materials"][1]["poissons_ratio"] = 0.5; } },
            { "/materials/1/density_tonne_per_mm3",
                [](Json& j) { j["materials"][1]["density_tonne_per_mm3"] = -1e-9; } },
            { "/materials/1/name", [](Json& j) { j["materials"][1]["name"] = j["materials"][0]["name"]; } },
            { "/materials/1/youngs_modulus", [](Json& j) { j["materials"][1]["youngs_modulus"] = 1.0; } },
            { "/supports/labels/0", [](Json& j) { j["supports"]["labels"][0] = "pelvis"; } },
            { "/supports/region_border", [](Json& j) { j["supports"]["region_border"] = 1; } },
            { "/sizing/corridor_edge_mm", [](Json& j) { j["sizing"]["corridor_edge_mm"] = 0.0; } },
            { "/sizing/coarse_edge_mm", [](Json& j) { j["sizing"]["coarse_edge_mm"] = 1.0; } },
            { "/views/1", [](Json& j) { j["views"][1] = "behind"; } },
            { "/approaches", [](Json& j) { j["approaches"] = Json::object(); } },
            { "/approaches/1/name", [](Json& j) { j["approaches"][1]["name"] = "first"; } },
            { "/approaches/1/name", [](Json& j) { j["approaches"][1]["name"] = "../second"; } },
            { "/approaches/0/depth_mm", [](Json& j) { j["approaches"][0]["depth_mm"] = -1.0; } },
            { "/approaches/0/depth_mm", [](Json& j) { j["approaches"][0]["depth_mm"] = "deep"; } },
            { "/approaches/0/depth_mm", [](Json& j) { j["approaches"][0].erase("depth_mm"); } },
            { "/approaches/0/depth", [](Json& j) { j["approaches"][0]["depth"] = 3.0; } },
            { "/approaches/0/incision_mm/2",
                [](Json& j) {
                    j["approaches"][0]["incision_mm"][2] = { 1.0, 2.0 };
                } },
            { "/approaches/0/incision_mm/2/1", [nan](Json& j) { j["approaches"][0]["incision_mm"][2][1] = nan; } },
            { "/approaches/0/incision_mm/3",
                [](Json& j) { j["approaches"][0]["incision_mm"][3] = j["approaches"][0]["incision_mm"][2]; } },
            { "/approaches/0/incision_mm", [](Json& j) { j["approaches"][0]["incision_mm"] = Json::array(); } },
            { "/approaches/0/directions", [](Json& j) { j["approaches"][0]["directions"].erase(0); } },
            { "/approaches/0/directions/4",
                [](Json& j) {
                    j["approaches"][0]["directions"][4] = { 0.0, 0.0, 2.0 };
                } },
            { "/approaches/0/wall_thickness_mm", [](Json& j) { j["approaches"][0]["wall_thickness_mm"].erase(0); } },
            { "/approaches/0/hook_depth_mm/0", [](Json& j) { j["approaches"][0]["hook_depth_mm"][0] = -2.0; } },
            { "/approaches/0/target/label", [](Json& j) { j["approaches"][0]["target"]["label"] = "spleen"; } },
            { "/approaches/0/target/label", [](Json& j) { j["approaches"][0]["target"]["label"] = ""; } },
            { "/approaches/0/target/radius_mm", [](Json& j) { j["approaches"][0]["target"]["radius_mm"] = 1.0; } },
            { "/approaches/1/target/radius_mm", [](Json& j) { j["approaches"][1]["target"]["radius_mm"] = 0.0; } },
            { "/approaches/2/target/radius_mm", [](Json& j) { j["approaches"][2]["target"]["radius_mm"] = 0.0; } },
            { "/approaches/2/target/radius_mm", [](Json& j) { j["approaches"][2]["target"].erase("radius_mm"); } },
            { "/approaches/2/target/centre_mm", [](Json& j) { j["approaches"][2]["target"].erase("centre_mm"); } },
            { "/approaches/2/target/site", [](Json& j) { j["approaches"][2]["target"]["site"] = ""; } },
            { "/approaches/2/target/site", [](Json& j) { j["approaches"][2]["target"]["site"] = "a\nb"; } },
            { "/approaches/2/target/centre_mm", [](Json& j) { j["approaches"][2]["target"].erase("site"); } },
            { "/approaches/0/retracted/0", [](Json& j) { j["approaches"][0]["retracted"][0] = "spleen"; } },
            { "/approaches/0/uncut_labels/0", [](Json& j) { j["approaches"][0]["uncut_labels"][0] = "spleen"; } },
            { "/approaches/0/loose_pieces", [](Json& j) { j["approaches"][0]["loose_pieces"] = "floating"; } },
            { "/approaches/0/loose_pieces", [](Json& j) { j["approaches"][0]["loose_pieces"] = 1; } },
            { "/approaches/0/division", [](Json& j) { j["approaches"][0]["division"] = "full"; } },
            { "/approaches/0/division/extent",
                [](Json& j) {
                    j["approaches"][0]["division"] = { { "forwards_mm", 10.0 } };
                } },
            { "/approaches/0/division/extent", [](Json& j) { j["approaches"][0]["division"]["extent"] = "half"; } },
            { "/approaches/0/division/forwards_mm",
                [](Json& j) { j["approaches"][0]["division"]["forwards_mm"] = -1.0; } },
            { "/approaches/0/division/backwards_mm",
                [](Json& j) {
                    j["approaches"][0]["division"] = { { "extent", "skin" }, { "backwards_mm", 10.0 } };
                } },
            { "/approaches/0/division/depth_mm", [](Json& j) { j["approaches"][0]["division"]["depth_mm"] = 10.0; } },
            { "/approaches/0/ablations", [](Json& j) { j["approaches"][0]["ablations"] = "rib"; } },
            { "/approaches/0/ablations/0/label",
                [](Json& j) { j["approaches"][0]["ablations"][0]["label"] = "spleen"; } },
            { "/approaches/0/ablations/0/label",
                [](Json& j) { j["approaches"][0]["ablations"][0]["label"] = "lung"; } }, // no wall
            { "/approaches/0/ablations/0/label", [](Json& j) { j["approaches"][0]["ablations"][0]["label"] = ""; } },
            { "/approaches/0/ablations/0/label", [](Json& j) { j["approaches"][0]["ablations"][0].erase("label"); } },
            { "/approaches/0/ablations/0/to_mm", [](Json& j) { j["approaches"][0]["ablations"][0].erase("to_mm"); } },
            { "/approaches/0/ablations/0/to_mm", [](Json& j) { j["approaches"][0]["ablations"][0]["to_mm"] = -11.0; } },
            { "/approaches/0/ablations/0/from_mm",
                [nan](Json& j) { j["approaches"][0]["ablations"][0]["from_mm"] = nan; } },
            { "/approaches/0/ablations/0/from_mm",
                [](Json& j) { j["approaches"][0]["ablations"][0]["radius_mm"] = 3.0; } }, // a ball or a segment
            { "/approaches/0/ablations/1/along_to_mm",
                [](Json& j) { j["approaches"][0]["ablations"][1]["along_to_mm"] = 1e3; } },
            { "/approaches/0/ablations/1/along_to_mm",
                [](Json& j) { j["approaches"][0]["ablations"][1]["along_to_mm"] = 1.0; } },
            { "/approaches/0/ablations/2/radius_mm",
                [](Json& j) { j["approaches"][0]["ablations"][2]["radius_mm"] = 0.0; } },
            { "/approaches/0/ablations/2/centre_mm/1",
                [nan](Json& j) { j["approaches"][0]["ablations"][2]["centre_mm"][1] = nan; } },
            { "/approaches/0/view/half_angle_deg",
                [](Json& j) { j["approaches"][0]["view"]["half_angle_deg"] = 90.0; } },
            { "/approaches/0/view/eye_count", [](Json& j) { j["approaches"][0]["view"]["eye_count"] = 0; } },
            { "/approaches/0/hooks/1/side", [](Json& j) { j["approaches"][0]["hooks"][1]["side"] = 0; } },
            { "/approaches/0/hooks/1/along_mm", [](Json& j) { j["approaches"][0]["hooks"][1]["along_mm"] = 1000.0; } },
            { "/approaches/0/hooks/1/direction",
                [](Json& j) {
                    j["approaches"][0]["hooks"][1]["direction"] = { 0.0, 0.0, 0.0 };
                } },
            { "/approaches/0/hooks/1/opening_mm",
                [](Json& j) { j["approaches"][0]["hooks"][1]["opening_mm"] = -1.0; } },
            { "/approaches/0/hooks/1/name",
                [](Json& j) { j["approaches"][0]["hooks"][1]["name"] = j["approaches"][0]["hooks"][0]["name"]; } },
            { "/approaches/0/hooks/1/patch_width_mm",
                [](Json& j) { j["approaches"][0]["hooks"][1]["patch_width_mm"] = 0.0; } },
        };
        for (const auto& [pointer, damage] : damages)
            EXPECT_EQ(refused_at(damage), pointer);
        EXPECT_EQ(refused_at([](Json&) {}), "accepted");
    }

    TEST_F(CaseFile, BadJsonIsRefused)
    {
        const std::string good = case_to_json(sample());
        EXPECT_EQ(refused_text(""), "/");
        EXPECT_EQ(refused_text(good.substr(0, good.size() / 2)), "/");
        EXPECT_EQ(refused_text("[]"), "/");
        EXPECT_EQ(refused_text(R"({"schema": 1, "schema": 1})"), "/"); // the second would win in silence
    }

    TEST_F(CaseFile, MissingAndChangedFilesAreRefused)
    {
        const auto refused_read = [&](const ReadCaseOptions& options = {}) -> std::string {
            try {
                read_case(folder_, options);
            } catch (const InputError& error) {
                return error.where();
            }
            return "accepted";
        };
        write_case(sample());
        EXPECT_EQ(refused_read(), "accepted");
        put("ct/2.dcm", "twice");
        EXPECT_EQ(refused_read(), "/ct/sha256");
        EXPECT_EQ(refused_read({ .verify_checksums = false }), "accepted");
        put("ct/2.dcm", "two");
        put("labels.nrrd", "Labels");
        EXPECT_EQ(refused_read(), "/labels/sha256");
        fs::remove(folder_ / "labels.nrrd");
        EXPECT_EQ(refused_read({ .verify_checksums = false }), "/labels/path");
        EXPECT_THROW(read_case(folder_ / "nothing"), IoError);
    }

    TEST_F(CaseFile, RefusedCaseLeavesTheOldFile)
    {
        write_case(sample());
        Case bad = sample();
        bad.approaches[0].depth_mm = std::numeric_limits<double>::quiet_NaN();
        EXPECT_THROW(write_case(bad), InputError);
        EXPECT_EQ(read_case(folder_).approaches[0].depth_mm, sample().approaches[0].depth_mm);
        EXPECT_THROW(make_reference(folder_, folder_ / ".." / "elsewhere"), InputError);
    }

    TEST_F(CaseFile, ApproachesAreAddedAndRemovedByName)
    {
        Case c = sample();
        EXPECT_THROW(add_approach(c, approach("first")), InputError);
        Approach lost = approach("fourth");
        lost.target.label = "spleen";
        EXPECT_THROW(add_approach(c, lost), InputError);
        EXPECT_EQ(c.approaches.size(), 3u);
        set_hooks(c, "second", "2", 40.0);
        EXPECT_EQ(find_approach(c, "second").hooks.size(), 2u);
        EXPECT_THROW(set_hooks(c, "fourth", "2", 40.0), InputError);
        remove_approach(c, "first");
        ASSERT_EQ(c.approaches.size(), 2u);
        EXPECT_EQ(c.approaches[0].name, "second");
        EXPECT_THROW(remove_approach(c, "first"), InputError);
    }

} // namespace case_io_test
} // namespace retractor::planner
