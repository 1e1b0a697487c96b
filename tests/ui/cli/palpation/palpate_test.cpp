// retractor palpate and relay as scripts see them: every model on every scene, hands that are simulated, recorded, on a
// Touch (behind a simulated vendor's library) and on another computer (this one).

#include "datasets/io/volume_io.h"
#include "haptics/device/udp_bridge.h"
#include "planner/case/import_case.h"
#include "tests/support/command_run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <array>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace palpate_test {

namespace fs = std::filesystem;
using Json = nlohmann::json;

using retractor::test_support::CommandRun;

/// @param before environment, or another program to be started first
CommandRun run(const std::string& arguments, const std::string& before = {})
{
    return retractor::test_support::run_line(
        before + " " + RETRACTOR_PROGRAM + " --json " + arguments + " 2>/dev/null");
}

std::string text_of(const fs::path& file)
{
    std::ifstream in(file);
    std::ostringstream text;
    text << in.rdbuf();
    return text.str();
}

double force_of(const Json& document, std::size_t finger = 0)
{
    return document.at("presses")[0].at("fingers")[finger].at("force_high_N").get<double>();
}

class Palpate : public testing::Test {
protected:
    static void SetUpTestSuite()
    {
        folder = fs::path(testing::TempDir()) / "palpate_command";
        fs::remove_all(folder);
        ASSERT_EQ(run("phantom sheet --out " + folder.string()).exit_code, 0);
    }
    static void TearDownTestSuite() { fs::remove_all(folder); }
    static std::string sheet() { return (folder / "sheet.json").string(); }
    static std::string out(const std::string& name) { return " --out " + (folder / name).string(); }
    static fs::path folder;
};
fs::path Palpate::folder;

const std::string kShort = " --seconds 0.3";
const std::string kTouch = std::string("RETRACTOR_HD_LIBRARY=") + RETRACTOR_SIMULATED_HD + " SIMULATED_DOWN=5";

TEST_F(Palpate, EveryModelAnswersOnTheSheet)
{
    for (const std::string model : { "fem", "springs", "spheres" }) {
        const CommandRun felt = run("palpate " + sheet() + " --model " + model + kShort + out(model + ".csv"));
        ASSERT_EQ(felt.exit_code, 0) << model;
        const Json document = felt.json();
        EXPECT_EQ(document.at("model"), model);
        EXPECT_GT(force_of(document), 0.01) << model;
        EXPECT_LT(force_of(document), 1.0) << model;
        for (const char* file : { "csv", "plot", "view" })
            EXPECT_GT(fs::file_size(document.at(file).get<std::string>()), 1000U) << model << ' ' << file;
    }
}

TEST_F(Palpate, SpringsOfALiverAreCalibratedAgainstItsElements)
{
    ASSERT_EQ(run("phantom liver --edge 20 --out " + folder.string()).exit_code, 0);
    const std::string scene = (folder / "liver.json").string();
    const std::string how = " --radius 10 --depth 3 --press right-lobe" + kShort + out("liver.csv");
    const CommandRun springs = run("palpate " + scene + " --model springs" + how);
    const CommandRun elements = run("palpate " + scene + " --fingertip sphere" + how);
    ASSERT_EQ(springs.exit_code + elements.exit_code, 0);
    constexpr double kAlike = 0.5; // calibrated at 2.5 mm; springs stiffen otherwise than linear elements
    EXPECT_NEAR(force_of(springs.json()) / force_of(elements.json()), 1.0, kAlike);
    EXPECT_NE(springs.json().at("notes")[0].get<std::string>().find("measured"), std::string::npos);
}

TEST_F(Palpate, SpringsOfAVesselFeelThePulseAndSpheresRefuseIt)
{
    ASSERT_EQ(run("phantom aorta --around 12 --along 24 --out " + folder.string()).exit_code, 0);
    const std::string scene = (folder / "aorta.json").string();
    const CommandRun springs
        = run("palpate " + scene + " --model springs --calibration 1 --press normal --seconds 1.6" + out("beat.csv"));
    ASSERT_EQ(springs.exit_code, 0);
    EXPECT_GT(springs.json().at("presses")[0].at("fingers")[0].at("pulse_N").get<double>(), 0.01);
    const CommandRun stiff = run(
        "palpate " + scene + " --model springs --calibration 2 --press sclerotic --seconds 1.6" + out("stiff.csv"));
    ASSERT_EQ(stiff.exit_code, 0);
    const Json hard = stiff.json().at("presses")[0].at("fingers")[0];
    // No chatter, however stiff: a pulse is a part of the force.
    EXPECT_LT(hard.at("pulse_N").get<double>(), 0.5 * hard.at("force_high_N").get<double>());
    const CommandRun spheres = run("palpate " + scene + " --model spheres" + out("x.csv"));
    EXPECT_EQ(spheres.exit_code, 2);
    EXPECT_NE(spheres.error().find("use the model fem or springs (option --model)"), std::string::npos);
    EXPECT_NE(spheres.json().at("where").get<std::string>().find("model spheres"), std::string::npos);
}

TEST_F(Palpate, SixFingersOnTheSkinMoveLiverAndStomach)
{
    ASSERT_EQ(run("phantom abdomen --touchable --out " + folder.string()).exit_code, 0);
    const CommandRun felt = run("palpate " + (folder / "abdomen.json").string()
        + " --model spheres --press liver-1+liver-2+liver-3+stomach-1+stomach-2+stomach-3 --radius 12 --depth 15"
        + kShort + out("six.csv"));
    ASSERT_EQ(felt.exit_code, 0);
    const Json press = felt.json().at("presses")[0];
    EXPECT_EQ(press.at("fingers").size(), 6U);
    for (const Json& organ : press.at("organs"))
        EXPECT_GT(organ.at("moved_mm").get<double>(), 0.5) << organ.at("organ");
}

TEST_F(Palpate, ARecordedPressIsFeltAgainAlike)
{
    const std::string motion = (folder / "motion.bin").string();
    const CommandRun first
        = run("palpate " + sheet() + " --device simulated --record " + motion + kShort + out("first.csv"));
    ASSERT_EQ(first.exit_code, 0);
    const CommandRun again = run("palpate " + sheet() + " --device replay:" + motion + kShort + out("again.csv"));
    ASSERT_EQ(again.exit_code, 0);
    // The last column is what the hand was given: after the limits of another device.
    const auto without_hand = [](const fs::path& file) {
        std::istringstream lines(text_of(file));
        std::string kept;
        for (std::string line; std::getline(lines, line);)
            kept += line.substr(0, line.rfind(',')) + '\n';
        return kept;
    };
    const std::string one = without_hand(folder / "first.csv"), two = without_hand(folder / "again.csv");
    EXPECT_GT(one.size(), 10000U);
    EXPECT_TRUE(one == two) << "every force, to the last digit written";
}

TEST_F(Palpate, AMousesRecordingIsPlayedWhereItWasMade)
{
    const std::string scene = (folder / "tube" / "aorta.json").string(), motion = (folder / "mouse.csv").string();
    ASSERT_EQ(
        run("phantom aorta --shape tube --around 12 --along 16 --out " + (folder / "tube").string()).exit_code, 0);
    const Json sites = Json::parse(text_of(scene)).at("sites");
    const Json& site = sites[0];
    // As the window writes it: a pointer whose frame is the scene's, pressing by 1.5 mm with a fingertip of 4 mm.
    std::ofstream file(motion);
    file << "# retractor motion recording, version 2\n# rate_hz: 1000\n# device: mouse; pointer; \n"
         << "# scene_from_device: 1,0,0,0,0,1,0,0,0,0,1,0,0\n"
         << "t_s,device,x_mm,y_mm,z_mm,qw,qx,qy,qz,vx_mm_s,vy_mm_s,vz_mm_s,commanded_x_N,commanded_y_N,commanded_z_N,"
            "applied_x_N,applied_y_N,applied_z_N,buttons\n";
    for (int i = 0; i <= 100; ++i) {
        file << 1e-3 * i << ",0";
        for (int axis = 0; axis < 3; ++axis)
            file << ','
                 << site.at("point_mm")[axis].get<double>()
                    + (8.0 - 0.055 * i) * site.at("outward")[axis].get<double>();
        file << ",1,0,0,0,0,0,0,0,0,0,0,0,0,0\n";
    }
    file.close();
    const auto highest = [&](const std::string& options) {
        const CommandRun felt = run("palpate " + scene + " --element p1 --press " + site.at("name").get<std::string>()
            + " --device replay:" + motion + kShort + options + out("mouse-forces.csv"));
        EXPECT_EQ(felt.exit_code, 0) << felt.error();
        return felt.json().at("presses")[0].at("fingers")[0].at("force_high_N").get<double>();
    };
    EXPECT_GT(highest(""), 0.05);
    EXPECT_EQ(highest(" --replay-at recorded"), highest(""));
    const double there = highest(""), elsewhere = highest(" --replay-at site");
    EXPECT_NE(there, elsewhere) << "the site is added to places in the scene";
}

TEST_F(Palpate, AHandIsShownWhereItIsAsked)
{
    const std::string press = "palpate " + sheet() + " --model springs" + kShort;
    const CommandRun bare = run(press + out("bare.csv")), held = run(press + " --hand built-in" + out("hand.csv"));
    ASSERT_EQ(bare.exit_code + held.exit_code, 0);
    const auto view = [](const retractor::test_support::CommandRun& felt) {
        return text_of(felt.json().at("view").get<std::string>());
    };
    EXPECT_NE(view(bare), view(held));
    EXPECT_EQ(text_of(folder / "bare.csv"), text_of(folder / "hand.csv")); // it is only shown
    std::ofstream(folder / "no-hand.obj") << "v 0 0 0\nv 9 0 0\nv 0 9 0\nf 1 2 3\n";
    const CommandRun refused = run(press + " --hand " + (folder / "no-hand.obj").string() + out("refused.csv"));
    EXPECT_NE(refused.exit_code, 0);
    EXPECT_NE(refused.error().find("its unit must be the millimetre"), std::string::npos) << refused.error();
    EXPECT_FALSE(fs::exists(folder / "refused.csv"));
}

TEST_F(Palpate, APressThatNamesNoSiteIsRefused)
{
    const CommandRun refused = run("palpate " + sheet() + " --press ," + out("none.csv"));
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_NE(refused.error().find("a press names no site"), std::string::npos) << refused.error();
}

/// A patient of labels alone: a vessel of 22 mm through the whole image, and a liver.
std::string vessel_case(const fs::path& folder)
{
    retractor::mesh::LabelVolume labels;
    labels.grid.size = { 40, 30, 40 };
    labels.grid.spacing = { 2.0, 2.0, 2.0 };
    labels.table = { { 1, "aorta", "vessel", retractor::mesh::Role::target },
        { 2, "liver", "liver", retractor::mesh::Role::wall } };
    for (int k = 0; k < 40; ++k)
        for (int j = 0; j < 30; ++j)
            for (int i = 0; i < 40; ++i)
                labels.voxels.push_back(std::hypot(i - 12.0, j - 14.0) <= 5.5 ? 1 : i >= 24 && i < 36 ? 2 : 0);
    fs::create_directories(folder);
    retractor::datasets::write_label_volume(folder / "in.nrrd", labels);
    retractor::planner::ImportRequest request;
    request.labels = { folder / "in.nrrd" };
    static_cast<void>(retractor::planner::write_import(retractor::planner::read_import(request), folder / "case.json"));
    return (folder / "case.json").string();
}

TEST_F(Palpate, AStructureOfACaseIsMadePalpableAndBeats)
{
    const std::string patient = vessel_case(folder / "case");
    const CommandRun made = run("palpable " + patient + " --structure aorta --edge 6 --out " + folder.string());
    ASSERT_EQ(made.exit_code, 0);
    EXPECT_TRUE(made.json().at("hollow").get<bool>());
    const CommandRun felt
        = run("palpate " + (folder / "aorta.json").string() + " --press front --seconds 1.5" + out("a.csv"));
    ASSERT_EQ(felt.exit_code, 0);
    const Json finger = felt.json().at("presses")[0].at("fingers")[0];
    EXPECT_GT(finger.at("force_low_N").get<double>(), 0.05);
    EXPECT_GT(finger.at("pulse_N").get<double>(), 0.02);
    EXPECT_LT(finger.at("force_high_N").get<double>(), 5.0);
    // In one go it is the same.
    const CommandRun at_once = run("palpate " + patient + " --structure liver --model spheres" + kShort + out("b.csv"));
    ASSERT_EQ(at_once.exit_code, 0);
    EXPECT_GT(force_of(at_once.json()), 0.001);
}

TEST_F(Palpate, WhatCannotBePalpatedIsNamed)
{
    const std::string patient = vessel_case(folder / "case");
    const auto refused = [](const std::string& arguments, const std::string& text) {
        const CommandRun no = run(arguments);
        EXPECT_EQ(no.exit_code, 2) << arguments;
        EXPECT_NE(no.error().find(text), std::string::npos) << no.error();
    };
    refused("palpate " + patient, "name the structure to palpate with --structure; there are aorta, liver");
    refused("palpate " + patient + " --structure spleen", "there is no structure \"spleen\"; there are aorta, liver");
    refused("palpate " + sheet() + " --structure aorta", "this is a palpation scene");
    refused(
        "palpable " + patient + " --structure aorta --pressure 120,80 --out " + folder.string(), "DIASTOLIC,SYSTOLIC");
    refused("palpable " + patient + " --structure aorta --stiff 1,2,3 --out " + folder.string(), "x,y,z,r=MPA");
    refused(
        "palpable " + patient + " --out " + folder.string(), "name the structure to palpate; there are aorta, liver");
    const fs::path same_name = folder / "case" / "aorta.json"; // a case file may be named like the scene
    fs::copy_file(patient, same_name);
    refused("palpable " + same_name.string() + " --structure aorta --edge 6 --out " + (folder / "case").string(),
        "would overwrite the case file");
    EXPECT_EQ(run("approach list " + same_name.string()).exit_code, 0) << "it is still the case";
    // Said before the structure is looked at, let alone meshed.
    refused(
        "palpable " + patient + " --structure spleen --pressure 120,80 --out " + folder.string(), "DIASTOLIC,SYSTOLIC");
    EXPECT_EQ(run("palpable " + patient + " --structure spleen --out " + sheet() + "/below").exit_code, 1);
    refused("palpate " + patient + " --structure spleen --device mirrored" + out("x.csv"),
        "there is no device \"mirrored\"");
    EXPECT_EQ(run("palpate " + patient + " --structure spleen" + out("not/there.csv")).exit_code, 1);
    refused("palpate " + sheet() + " --depth nan" + out("x.csv"), "must be a number from 0.01 to 40, not nan");
    refused("palpate " + sheet() + " --device mirrored" + out("x.csv"), "there is no device \"mirrored\"");
    EXPECT_EQ(run("palpate " + sheet() + " --out " + (folder / "not" / "there.csv").string()).exit_code, 1);
}

TEST_F(Palpate, DevicesThatNobodyUsesAreRefused)
{
    const CommandRun two = run("palpate " + sheet() + " --device fixed --device simulated" + out("x.csv"));
    EXPECT_EQ(two.exit_code, 2);
    EXPECT_NE(two.error().find("2 devices for 1 fingers"), std::string::npos);
    const CommandRun one = run("palpate " + sheet() + " --press centre+centre --device touch" + out("x.csv"));
    EXPECT_EQ(one.exit_code, 2);
    EXPECT_NE(one.error().find("2 fingers need as many devices"), std::string::npos);
}

TEST_F(Palpate, ATouchPressesThroughTheVendorsLibrary)
{
    const CommandRun felt = run("palpate " + sheet() + " --device touch" + kShort + out("touch.csv"), kTouch);
    ASSERT_EQ(felt.exit_code, 0);
    EXPECT_GT(force_of(felt.json()), 0.05);
    EXPECT_GT(felt.json().at("presses")[0].at("ticks").get<int>(), 200);
}

TEST_F(Palpate, TwoTouchesAndASimulatedHandPressTogether)
{
    ASSERT_EQ(run("phantom aorta --around 12 --along 24 --out " + folder.string()).exit_code, 0);
    const CommandRun felt = run("palpate " + (folder / "aorta.json").string()
            + " --element p1 --press normal+normal-opposite+sclerotic --device \"touch:Left Device\" --device "
              "\"mirrored:touch:Default Device\" "
              "--device simulated"
            + kShort + out("three.csv"),
        kTouch);
    ASSERT_EQ(felt.exit_code, 0);
    for (std::size_t finger = 0; finger < 3; ++finger)
        EXPECT_GT(force_of(felt.json(), finger), 0.01) << finger;
}

TEST_F(Palpate, WithoutTheVendorsLibraryTheDoctorIsNamed)
{
    const CommandRun felt
        = run("palpate " + sheet() + " --device touch" + out("x.csv"), "RETRACTOR_HD_LIBRARY=libNoSuchHD.so");
    EXPECT_EQ(felt.exit_code, 1);
    EXPECT_NE(felt.error().find("retractor doctor"), std::string::npos);
    EXPECT_NE(felt.error().find("libNoSuchHD.so"), std::string::npos);
}

/// A port that nobody had a moment ago.
std::string free_port()
{
    const retractor::haptics::DatagramSocket socket("127.0.0.1", 0);
    return std::to_string(socket.port());
}

TEST_F(Palpate, AHandOnAnotherComputerPressesThroughTheRelay)
{
    const std::string port = free_port(), told = (folder / "relay.json").string();
    const std::string relay = std::string(RETRACTOR_PROGRAM) + " --json relay --device simulated --to 127.0.0.1:" + port
        + " > " + told + " 2>/dev/null & relay=$!; ";
    const CommandRun felt = run("palpate " + sheet() + " --device udp:127.0.0.1:" + port + " --seconds 2"
            + out("udp.csv") + "; code=$?; kill -TERM $relay; wait $relay; exit $code",
        relay);
    ASSERT_EQ(felt.exit_code, 0) << felt.out;
    EXPECT_GT(force_of(felt.json()), 0.0);
    const Json sent = Json::parse(text_of(told));
    EXPECT_GT(sent.at("ticks").get<int>(), 0);
    EXPECT_EQ(sent.at("devices")[0].at("to"), "127.0.0.1:" + port);
}

TEST_F(Palpate, SilenceFromAnotherComputerIsToldNotWaitedFor)
{
    const CommandRun felt
        = run("palpate " + sheet() + " --device udp:127.0.0.1:" + free_port() + kShort + out("x.csv"));
    EXPECT_EQ(felt.exit_code, 1);
    EXPECT_NE(felt.error().find("the other computer sent nothing"), std::string::npos);
    EXPECT_EQ(run("relay --device simulated --to nowhere").exit_code, 2);
    const CommandRun mirrored = run("relay --device mirrored:simulated --to 127.0.0.1:4000 --seconds 0.1");
    EXPECT_EQ(mirrored.exit_code, 2);
    EXPECT_NE(mirrored.error().find("mirrored on the computer that receives it"), std::string::npos) << mirrored.out;
    EXPECT_EQ(run("relay --device simulated --device simulated --to 127.0.0.1:4000").exit_code, 2);
}

TEST_F(Palpate, TraineesFeelTheModelsThroughADevice)
{
    const CommandRun tested = run("train test --store " + (folder / "t.sqlite").string()
            + " --trainee one --models 5 --device simulated --scene " + sheet() + " --seconds 0.2",
        "printf 'feel 2\\nfeel 4\\nfeel 9\\n3\\n' |");
    ASSERT_EQ(tested.exit_code, 0);
    EXPECT_EQ(tested.json().at("felt"), Json({ 2, 4 }));
    EXPECT_EQ(tested.json().at("choices").size(), 1U);
    const CommandRun alone = run("train test --store " + (folder / "t.sqlite").string() + " --trainee two --models 5",
        "printf 'feel 2\\n3\\n' |");
    ASSERT_EQ(alone.exit_code, 0);
    EXPECT_TRUE(alone.json().at("felt").empty());
}

} // namespace palpate_test
