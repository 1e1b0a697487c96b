// The command line as scripts see it: the built executable is run, its output parsed.

#include "tests/support/command_run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>
#include <set>
#include <string>
#include <utility>

namespace command_line_test {

namespace fs = std::filesystem;
using Json = nlohmann::json;

using retractor::test_support::CommandRun;

CommandRun run_program(const std::string& line) { return retractor::test_support::run_line(line + " 2>/dev/null"); }

CommandRun run(const std::string& arguments) { return run_program(std::string(RETRACTOR_PROGRAM) + " " + arguments); }

std::set<std::string> parts_of(const Json& document)
{
    std::set<std::string> parts;
    for (const Json& part : document.at("profile"))
        parts.insert(part.at("part").get<std::string>());
    return parts;
}

/// A block phantom, imported, with one approach: made once for all tests of this program.
class CommandLine : public testing::Test {
protected:
    static void SetUpTestSuite()
    {
        folder = fs::path(testing::TempDir()) / "command_line";
        fs::remove_all(folder);
        const std::string p = (folder / "p").string();
        ASSERT_EQ(run("phantom block --out " + p).exit_code, 0);
        ASSERT_EQ(run("import " + p + "/ct --labels " + p + "/labels.nrrd --out " + case_file()).exit_code, 0);
        ASSERT_EQ(run("approach add " + case_file()
                      + " --name straight --points 1.3,0,-25 0.9,0,0 1.3,0,25 --target target --retract cavity --hooks "
                        "2 --opening 20")
                      .exit_code,
            0);
        solve_quickly(case_file());
    }
    /// Four-node elements take a quarter of the time: these tests look at commands and what they say, not at forces.
    static void solve_quickly(const std::string& file)
    {
        std::ifstream in(file);
        Json document = Json::parse(in);
        document["solution"]["element"] = "p1";
        std::ofstream(file) << document.dump(2);
    }
    static std::string case_file() { return (folder / "c" / "case.json").string(); }
    static std::string out(const char* name) { return (folder / name).string(); }
    static inline fs::path folder;
};

TEST_F(CommandLine, HelpHasAnExampleForEveryCommand)
{
    for (const char* command :
        { "phantom", "import", "labels list", "labels paint", "labels interpolate", "approach add", "approach guide",
            "hooks", "tension", "vessels", "mesh", "cut", "plan", "render", "compare", "search", "ports", "batch",
            "demo", "doctor", "palpable", "palpate", "relay", "train", "train expert", "train test", "train report",
            "evidence", "evidence complications", "evidence rules", "evidence show-rule", "evidence generate" }) {
        const CommandRun help = run(std::string(command) + " --help");
        EXPECT_EQ(help.exit_code, 0) << command;
        EXPECT_NE(help.out.find("Example: retractor"), std::string::npos) << command;
    }
}

TEST_F(CommandLine, LabelsAreCorrectedAndTheApproachesFollow)
{
    const std::string p = out("p"), file = out("corrected/case.json");
    ASSERT_EQ(run("import " + p + "/ct --labels " + p + "/labels.nrrd --no-contact-sheet --out " + file).exit_code, 0);
    ASSERT_EQ(run("approach add " + file
                  + " --name straight --points 1.3,0,-25 0.9,0,0 1.3,0,25 --target target --retract cavity --hooks 2 "
                    "--opening 20")
                  .exit_code,
        0);
    const auto volumes = [&] {
        std::map<std::string, double> ml;
        const CommandRun list = run("--json labels list " + file);
        EXPECT_EQ(list.exit_code, 0);
        const Json document = list.json();
        for (const Json& label : document.at("labels"))
            ml[label.at("name").get<std::string>()] = label.at("volume_ml").get<double>();
        return ml;
    };
    const std::map<std::string, double> before = volumes();
    ASSERT_TRUE(before.contains("target"));
    const CommandRun paint = run("--json labels paint " + file + " --label target --at 0,20,0 --at 0,30,0 --radius 6");
    ASSERT_EQ(paint.exit_code, 0) << paint.out;
    EXPECT_NEAR(volumes().at("target") - before.at("target"), paint.json().at("volume_ml").get<double>(), 1e-6);
    EXPECT_TRUE(fs::exists(folder / "corrected" / "labels.nrrd")) << "the labels before stay";
    EXPECT_EQ(paint.json().at("labels"), "labels-2.nrrd");
    ASSERT_EQ(run("labels erase " + file + " --label target --at 0,20,0 --at 0,30,0 --radius 12").exit_code, 0);
    EXPECT_LT(volumes().at("target"), before.at("target") + 1e-6);
    ASSERT_EQ(run("labels rename " + file + " --label target --to aneurysm").exit_code, 0);
    EXPECT_TRUE(volumes().contains("aneurysm"));
    EXPECT_NE(run("approach list " + file).out.find("target aneurysm"), std::string::npos);
    // Errors name the option, and leave the case.
    for (const char* wrong :
        { "paint CASE --label spleen --at 0,0,0 --radius 3", "rename CASE --label aneurysm --to cavity",
            "join CASE --label aneurysm --to aneurysm", "confirm CASE --label aneurysm",
            "paint CASE --label aneurysm --at 0,0 --radius 3", "paint CASE --label aneurysm --at 0,0,0 --radius 0",
            "smooth CASE --label aneurysm --voxels 0", "fill CASE --label aneurysm --at 9999,0,0" }) {
        std::string line = wrong;
        line.replace(line.find("CASE"), 4, file);
        EXPECT_EQ(run("labels " + line).exit_code, 2) << wrong;
    }
    EXPECT_TRUE(volumes().contains("aneurysm"));
}

TEST_F(CommandLine, ACaseFileMayHaveAnyName)
{
    const std::string p = out("p"), first = out("named/first.json"), second = out("named/second.json");
    for (const std::string& file : { first, second })
        ASSERT_EQ(
            run("import " + p + "/ct --labels " + p + "/labels.nrrd --no-contact-sheet --out " + file).exit_code, 0);
    // What is planned in one of them goes into no other file.
    ASSERT_EQ(run("approach add " + second
                  + " --name straight --points 1.3,0,-25 0.9,0,0 1.3,0,25 --target target --retract cavity --hooks 2 "
                    "--opening 20")
                  .exit_code,
        0);
    EXPECT_EQ(run("hooks " + second + " --approach straight --template 2 --opening 15").exit_code, 0);
    solve_quickly(second);
    EXPECT_FALSE(fs::exists(folder / "named" / "case.json"));
    EXPECT_EQ(run("approach list " + first).out.find("straight"), std::string::npos);
    EXPECT_NE(run("approach list " + second).out.find("straight"), std::string::npos);
    // Another title changes no name: commands and files stay.
    EXPECT_EQ(run("approach rename " + second + " --name straight --title Long").exit_code, 0);
    EXPECT_NE(run("approach list " + second).out.find("called Long"), std::string::npos);
    EXPECT_EQ(run("approach rename " + second + " --name nobody --title Long").exit_code, 2);
    EXPECT_EQ(run("approach rename " + second + " --name straight --title ''").exit_code, 0);
    EXPECT_EQ(run("approach list " + second).out.find("called"), std::string::npos);
    // And everything that opens a case opens this one.
    EXPECT_EQ(run("mesh " + second + " --approach straight --out " + out("named_mesh")).exit_code, 0);
    const std::string journal = out("named_cut/cuts.jsonl");
    EXPECT_EQ(
        run("cut " + second + " --approach straight --out " + out("named_cut") + " --journal " + journal).exit_code, 0);
    EXPECT_EQ(
        run("cut " + second + " --approach straight --out " + out("named_again") + " --replay " + journal).exit_code,
        0);
    const CommandRun plan = run("--json plan " + second + " --accuracy none --out " + out("named_plan"));
    ASSERT_EQ(plan.exit_code, 0);
    EXPECT_EQ(plan.json().at("computed").at("case"), "named/second.json");
    EXPECT_EQ(run("render " + second + " --views overview --size 320x240 --out " + out("named_pictures")).exit_code, 0);
    // A folder stands for the case.json in it.
    EXPECT_NE(run("approach list " + out("named")).exit_code, 0);
}

TEST_F(CommandLine, UsageAndBadInputExitWithTwoAndOneJsonDocument)
{
    EXPECT_EQ(run("no-such-command").exit_code, 2);
    EXPECT_EQ(run("plan").exit_code, 2);
    EXPECT_EQ(run("plan " + case_file() + " --check --out " + out("x")).exit_code, 2); // of what, without --near
    for (const char* wrong : { "--local 60", "--near nan", "--near -1", "--reference-limit nan", "--accuracy 15",
             "--accuracy 0.1%", "--accuracy 15%,30", "--time 0", "--time nan", "--draft --accuracy 15%" })
        EXPECT_EQ(run("plan " + case_file() + " " + wrong + " --out " + out("x")).exit_code, 2) << wrong;
    const CommandRun missing = run("--json plan " + out("none/case.json") + " --out " + out("x"));
    EXPECT_NE(missing.exit_code, 0);
    EXPECT_TRUE(missing.json().contains("error"));
    EXPECT_TRUE(missing.json().contains("where"));
    const CommandRun unknown = run("--json plan " + case_file() + " --approach nobody --out " + out("x"));
    EXPECT_EQ(unknown.exit_code, 2);
    EXPECT_NE(unknown.json().at("error").get<std::string>().find("straight"), std::string::npos); // says what there is
    EXPECT_EQ(run("render " + case_file() + " --out " + out("x") + " --size 0x10").exit_code, 2);
    EXPECT_EQ(run("render " + case_file() + " --out " + out("x") + " --views sideways").exit_code, 2);
    EXPECT_EQ(run("hooks " + case_file() + " --approach straight --opening -5").exit_code, 2);
    const std::string hooks = "hooks " + case_file() + " --approach straight --template 2 ";
    for (const char* contradiction : { "", "--hook-force 20 --opening 10", "--hook-limit 5",
             "--hook-grip 0 --opening 10", "--hook-force 20 --hook-limit 5", "--hook-force 20 --turn-every 20",
             "--opening 10 --turn-every -1", "--opening 10 --turn-every nan" })
        EXPECT_EQ(run(hooks + contradiction).exit_code, 2) << contradiction;
}

TEST_F(CommandLine, ListsOfWordsAreWrittenWithCommasOrSpaces)
{
    for (const char* organs : { "cavity,target", "cavity target" }) {
        fs::copy(folder / "c", folder / "lists", fs::copy_options::recursive | fs::copy_options::overwrite_existing);
        const CommandRun added = run("--json approach add " + out("lists/case.json")
            + " --name listed --points 1.3,0,-25 1.3,0,25 --target target --retract " + organs);
        ASSERT_EQ(added.exit_code, 0) << organs;
        EXPECT_EQ(added.json().at("retracted"), Json({ "cavity", "target" })) << organs;
    }
}

TEST_F(CommandLine, PalpateWritesForcesOfBothRegions)
{
    const CommandRun phantom = run("--json phantom aorta --out " + out("aorta") + " --around 14 --along 28");
    ASSERT_EQ(phantom.exit_code, 0);
    EXPECT_EQ(phantom.json().at("vertices").get<int>(), 14 * 2 * 29);
    const std::string scene = phantom.json().at("scene").get<std::string>();
    const CommandRun felt
        = run("--json --profile palpate " + scene + " --seconds 1.5 --out " + out("aorta/forces.csv"));
    ASSERT_EQ(felt.exit_code, 0);
    const Json document = felt.json();
    ASSERT_EQ(document.at("presses").size(), 2U);
    const Json normal = document.at("presses")[0].at("fingers")[0], stiff = document.at("presses")[1].at("fingers")[0];
    EXPECT_EQ(normal.at("site"), "normal");
    EXPECT_GT(stiff.at("force_high_N").get<double>(), 1.2 * normal.at("force_high_N").get<double>());
    // As in fig. 7 of the paper. Ten-node elements show this order; four-node elements on such a coarse vessel show the
    // opposite one.
    EXPECT_LT(stiff.at("pulse_N").get<double>(), 0.9 * normal.at("pulse_N").get<double>());
    for (const char* file : { "csv", "plot", "view" })
        EXPECT_GT(fs::file_size(document.at(file).get<std::string>()), 1000U) << file;
    EXPECT_TRUE(parts_of(document).count("condensed tissue"));
    EXPECT_FALSE(parts_of(document).count("voxels"));
    std::ifstream csv(document.at("csv").get<std::string>());
    std::string header;
    std::getline(csv, header);
    EXPECT_NE(header.find("time_s,pressure_mmHg"), std::string::npos);
    const CommandRun pinched = run("--json palpate " + scene
        + " --element p1 --seconds 0.5 --pinch normal --device simulated --out " + out("aorta/pinch.csv"));
    ASSERT_EQ(pinched.exit_code, 0);
    EXPECT_EQ(pinched.json().at("presses")[0].at("fingers").size(), 2U);
    const CommandRun unknown = run("--json palpate " + scene + " --press left --out " + out("aorta/x.csv"));
    EXPECT_EQ(unknown.exit_code, 2);
    EXPECT_NE(unknown.json().at("error").get<std::string>().find("normal"), std::string::npos); // says what there is
    EXPECT_EQ(run("palpate " + scene + " --device ghost --out " + out("aorta/x.csv")).exit_code, 2);
    EXPECT_EQ(run("phantom aorta --region wide --out " + out("x")).exit_code, 2);
}

TEST_F(CommandLine, MeshBuildsNoSolver)
{
    const CommandRun mesh = run("--json --profile mesh " + case_file() + " --approach straight --out " + out("mesh"));
    ASSERT_EQ(mesh.exit_code, 0);
    const auto parts = parts_of(mesh.json());
    EXPECT_TRUE(parts.count("tetrahedra"));
    EXPECT_FALSE(parts.count("factorisation"));
    EXPECT_FALSE(parts.count("assembly"));
    EXPECT_FALSE(parts.count("voxels"));
    EXPECT_FALSE(parts.count("renderer"));
    EXPECT_GT(mesh.json().at("tets").get<int>(), 1000);
    EXPECT_TRUE(fs::exists(fs::path(out("mesh")) / "straight-uncut.vtu"));
}

// The same approach with its incision in the air leaves no journal that would stand in the way of the next try.
TEST_F(CommandLine, ARefusedCutLeavesNoJournal)
{
    Json beside = Json::parse(std::ifstream(case_file()));
    for (Json& point : beside.at("approaches")[0].at("incision_mm"))
        point[1] = point[1].get<double>() - 35.0; // further than the blade is deep
    const fs::path beside_file = fs::path(case_file()).parent_path() / "beside.json";
    std::ofstream(beside_file) << beside;
    const std::string journal = out("refused.jsonl"), rest = " --approach straight --out " + out("refused");
    EXPECT_EQ(run("--json cut " + beside_file.string() + rest + "/deep --journal " + journal).exit_code, 1);
    EXPECT_FALSE(fs::exists(journal));
    EXPECT_FALSE(fs::exists(out("refused"))) << "nor an empty folder";
    EXPECT_EQ(run("--json cut " + case_file() + rest + " --journal " + journal).exit_code, 0);
    EXPECT_TRUE(fs::exists(journal));
}

TEST_F(CommandLine, CutIsReplayedFromItsJournal)
{
    const std::string journal = out("cuts.jsonl");
    fs::remove(journal);
    const std::string cut = "--json cut " + case_file() + " --approach straight --out ";
    const CommandRun first = run(cut + out("cut") + " --journal " + journal);
    ASSERT_EQ(first.exit_code, 0);
    const Json report = first.json();
    EXPECT_GT(report.at("report").at("tets_crossed").get<int>(), 100);
    EXPECT_GT(report.at("tets"), report.at("uncut_mesh").at("tets"));
    EXPECT_EQ(report.at("cuts").get<int>(), 1);
    EXPECT_TRUE(report.at("pieces").at(0).at("held").get<bool>());
    EXPECT_TRUE(fs::exists(fs::path(out("cut")) / "straight-cut.vtu"));
    EXPECT_TRUE(fs::exists(fs::path(out("cut")) / "report.json"));
    const CommandRun again = run(cut + out("again") + " --replay " + journal);
    ASSERT_EQ(again.exit_code, 0);
    EXPECT_EQ(again.json().at("replayed").get<int>(), 1);
    EXPECT_EQ(again.json().at("pieces"), report.at("pieces"));
    const CommandRun undone = run(cut + out("undone") + " --replay " + journal + " --undo 1");
    ASSERT_EQ(undone.exit_code, 0);
    EXPECT_EQ(undone.json().at("tets"), report.at("uncut_mesh").at("tets"));
    const CommandRun too_many = run(cut + out("undone") + " --replay " + journal + " --undo 2");
    EXPECT_EQ(too_many.exit_code, 2);
    EXPECT_EQ(too_many.json().at("error"), "there is only 1 cut to undo");
    const CommandRun negative = run(cut + out("undone") + " --replay " + journal + " --undo -1");
    EXPECT_EQ(negative.exit_code, 2);
    EXPECT_EQ(negative.json().at("error"), "must be 0 or more, got -1");
    EXPECT_EQ(run(cut + out("undone") + " --finish").exit_code, 2) << "of no journal";
    EXPECT_EQ(run(cut + out("undone") + " --replay " + journal + " --finish").exit_code, 2) << "no stroke is open";
    EXPECT_EQ(run(cut + out("cut") + " --journal " + journal).exit_code, 1); // never over a journal
    // Another journal beside a replay would not be written: it is refused, whatever its name; the same one goes on.
    EXPECT_EQ(run(cut + out("undone") + " --replay " + journal + " --journal " + out("other.jsonl")).exit_code, 2);
    EXPECT_FALSE(fs::exists(out("other.jsonl")));
    const std::string same = (folder / "." / "cuts.jsonl").string();
    const CommandRun on = run(cut + out("on") + " --replay " + journal + " --journal " + same + " --undo 1");
    ASSERT_EQ(on.exit_code, 0) << on.out;
    EXPECT_EQ(run(cut + out("on") + " --replay " + journal).json().at("replayed").get<int>(), 2);
    EXPECT_EQ(run("--json cut " + case_file() + " --approach none --out " + out("cut")).exit_code, 2);
}

TEST_F(CommandLine, PlanWithoutRenderBuildsNoRenderer)
{
    const CommandRun plan = run("--json --profile plan " + case_file() + " --accuracy none --out " + out("plan"));
    ASSERT_EQ(plan.exit_code, 0);
    const Json document = plan.json();
    const auto parts = parts_of(document);
    EXPECT_TRUE(parts.count("factorisation"));
    EXPECT_TRUE(parts.count("ray tracer"));
    EXPECT_FALSE(parts.count("renderer"));
    EXPECT_FALSE(parts.count("volume rendering"));
    EXPECT_FALSE(parts.count("voxels"));
    EXPECT_GT(document.at("approaches").at(0).at("seen_best_eye").get<double>(), 0.0);
    std::ifstream file(fs::path(out("plan")) / "metrics.json");
    EXPECT_EQ(Json::parse(file).at("approaches").at(0).at("name"), "straight");
}

TEST_F(CommandLine, SearchProposesKeepsAndDrawsIncisions)
{
    const fs::path copy = folder / "searched";
    fs::copy(folder / "c", copy, fs::copy_options::recursive);
    const std::string file = (copy / "case.json").string();
    const std::string search = "--json search " + file
        + " --anywhere --retract cavity --length 40-60 --hooks 2 "
          "--opening 20 --drafts 2 --draft-time 0 ";
    const CommandRun found = run(search + "--keep --out " + out("search"));
    ASSERT_EQ(found.exit_code, 0) << found.out;
    const Json document = found.json();
    EXPECT_GT(document.at("tried").get<int>(), 100);
    EXPECT_GE(document.at("drafts").at("approaches").size(), 1u);
    EXPECT_TRUE(fs::exists(fs::path(out("search")) / "search-map.png"));
    std::ifstream written(fs::path(out("search")) / "search.json");
    EXPECT_EQ(Json::parse(written).at("tried"), document.at("tried"));
    std::ifstream kept(file);
    const Json approaches = Json::parse(kept).at("approaches");
    EXPECT_EQ(approaches.size(), 1u + document.at("kept").size());
    EXPECT_EQ(approaches.back().at("retracted"), Json::parse("[\"cavity\"]"));
    const CommandRun no_landmarks = run("--json search " + file);
    EXPECT_EQ(no_landmarks.exit_code, 2);
    EXPECT_NE(no_landmarks.error().find("anywhere on the skin"), std::string::npos) << no_landmarks.error();
    for (const char* wrong : { "--retract nothing", "--length 60-40", "--length x", "--spaces 0-3", "--spaces 1.5",
             "--target nobody", "--opening 1", "--retractor spoon" })
        EXPECT_EQ(run(search + wrong).exit_code, 2) << wrong;
}

TEST_F(CommandLine, SavedPlansAreDrawnAndComparedWithoutPlanningAgain)
{
    const fs::path saved = folder / "saved";
    fs::copy(folder / "c", saved, fs::copy_options::recursive);
    fs::remove_all(saved / "plans");
    const std::string file = (saved / "case.json").string();
    std::ifstream written(file);
    Json quick = Json::parse(written);
    quick["solution"]["accuracy"] = { { "force", 1.0 }, { "opening", 20.0 }, { "time", 60.0 } }; // the first mesh
    std::ofstream(file) << quick.dump(2);
    const CommandRun alone = run("--json compare " + file);
    EXPECT_EQ(alone.exit_code, 2);
    EXPECT_NE(alone.error().find("a comparison needs two planned approaches, and the case has 0"), std::string::npos);
    ASSERT_EQ(run("approach add " + file
                  + " --name drawn --points 1.3,0,-25 0.9,0,0 1.3,0,25 --target target --retract cavity --hooks 2 "
                    "--opening 24")
                  .exit_code,
        0);
    for (const char* option : { "--edge 6", "--accuracy none" })
        ASSERT_EQ(run("plan " + file + " " + option + " --approach straight --out " + out("saved_plan")).exit_code, 0);
    EXPECT_FALSE(fs::exists(saved / "plans")) << "an option changed these plans";
    const CommandRun plan = run("plan " + file + " --render --out " + out("saved_plan"));
    ASSERT_EQ(plan.exit_code, 0) << plan.out;
    EXPECT_NE(
        plan.out.find("saved with the case, for retractor render and the window: straight, drawn"), std::string::npos)
        << plan.out;
    std::ifstream report(folder / "saved_plan" / "report.html");
    const std::string page { std::istreambuf_iterator<char>(report), {} };
    EXPECT_NE(page.find("<h2>straight</h2>"), std::string::npos) << "a name of its own";
    EXPECT_NE(page.find("<h2>Drawn incision</h2>"), std::string::npos) << "as surgeons call it";
    const CommandRun render
        = run("--json --profile render " + file + " --views surgeon,overview --out " + out("saved_render"));
    ASSERT_EQ(render.exit_code, 0) << render.out;
    EXPECT_TRUE(render.json().at("saved_plans").contains("drawn"));
    EXPECT_FALSE(parts_of(render.json()).count("factorisation"));
    const auto bytes = [](const fs::path& picture) {
        std::ifstream in(picture, std::ios::binary);
        return std::string(std::istreambuf_iterator<char>(in), {});
    };
    for (const char* picture : { "straight-surgeon.png", "straight-overview.png", "drawn-surgeon.png" })
        EXPECT_TRUE(bytes(folder / "saved_render" / picture) == bytes(folder / "saved_plan" / picture)) << picture;
    // The same plans as a movie.
    const CommandRun movie = run("--json render " + file + " --play --frames --size 160x120 --out " + out("movie"));
    ASSERT_EQ(movie.exit_code, 0) << movie.out;
    EXPECT_EQ(bytes(folder / "movie" / "movie.webm").substr(0, 4), "\x1A\x45\xDF\xA3") << "EBML, as WebM begins";
    const auto frames = std::distance(fs::directory_iterator(folder / "movie" / "frames"), {});
    constexpr int kFramesOfAStep = 80; // 4 s
    EXPECT_GT(frames, 2 * 4 * kFramesOfAStep) << "two plans, with four steps at least";
    EXPECT_EQ(run("render " + file + " --play --size 161x120 --out " + out("odd_movie")).exit_code, 2);

    const CommandRun compared = run("compare " + file);
    ASSERT_EQ(compared.exit_code, 0) << compared.out;
    EXPECT_NE(compared.out.find("A  straight: "), std::string::npos) << compared.out;
    EXPECT_NE(compared.out.find("Target seen, best eye"), std::string::npos) << compared.out;
    EXPECT_NE(compared.out.find("Score of 100 points (weights: seen 3, "), std::string::npos) << compared.out;
    const Json document = run("--json compare " + file).json();
    EXPECT_EQ(document.at("approaches").size(), 2u);
    EXPECT_EQ(document.at("ranking").size(), 2u);
    const Json seen_only
        = run("--json compare " + file + " --weights seen=1,instruments=0,angle=0,incision=0,bone=0,risk=0,force=0")
              .json();
    for (const Json& row : seen_only.at("ranking"))
        EXPECT_NEAR(row.at("points").get<double>(), 100.0 * row.at("shares").at("seen").get<double>(), 1e-9);
    for (const char* wrong : { "--weights beauty=1", "--weights seen", "--weights seen=-1", "--weights seen=nan",
             "--weights seen=0,instruments=0,angle=0,incision=0,bone=0,risk=0,force=0", "--draft",
             "--neighbours --approach nobody" })
        EXPECT_EQ(run("compare " + file + " " + wrong).exit_code, 2) << wrong;
    std::ifstream metrics(fs::path(out("saved_plan")) / "metrics.json");
    const Json fields = Json::parse(metrics).at("approaches");
    for (const Json& row : document.at("measures")) {
        if (row.at("key") != "seen_best_eye")
            continue;
        for (std::size_t n = 0; n < 2; ++n)
            EXPECT_EQ(row.at("values").at(n), fields.at(n).at("seen_best_eye"));
    }
    // The block has no ribs, so that neighbours lie along the incision only.
    const CommandRun beside = run("--json compare " + file + " --neighbours --approach drawn --draft --keep");
    ASSERT_EQ(beside.exit_code, 0) << beside.out;
    const Json group = beside.json().at("neighbours").at(0);
    EXPECT_EQ(group.at("of"), "drawn");
    EXPECT_EQ(group.at("approaches").size() + group.at("missing").size(), 3u);
    EXPECT_GE(group.at("approaches").size(), 2u);
    EXPECT_TRUE(group.at("ranking").at(0).at("bar").is_null()) << "a draft has no error bars";
    EXPECT_NE(
        run("approach list " + file).out.find(beside.json().at("kept").at(0).get<std::string>()), std::string::npos);

    ASSERT_EQ(run("approach remove " + file + " --name straight").exit_code, 0);
    ASSERT_EQ(run("hooks " + file + " --approach drawn --template 2 --opening 22").exit_code, 0);
    EXPECT_EQ(run("compare " + file).exit_code, 2) << "no plan is of what the case holds now";
}

TEST_F(CommandLine, EvidenceHasThePublishedCounts)
{
    const std::string data = out("evidence/records");
    ASSERT_EQ(run("evidence generate complications --out " + data).exit_code, 0);
    const std::string database = out("evidence/records.sqlite");
    for (const auto& [rule, found] : { std::pair { "shock-accounting", 5 }, { "shock-orders", 4 } }) {
        const CommandRun result
            = run("--json evidence complications " + data + " --rule " + rule + " --db " + database);
        ASSERT_EQ(result.exit_code, 0) << result.out;
        EXPECT_EQ(result.json().at("found_examinations"), found);
        EXPECT_EQ(result.json().at("precision").at("successes"), 3);
        EXPECT_TRUE(fs::exists(database));
    }
    // A rule of one's own, begun with a published one.
    const std::string sql = run("evidence show-rule shock-orders").out;
    EXPECT_NE(sql.find("SELECT e.examination"), std::string::npos);
    std::ofstream(out("evidence/rule.sql")) << sql;
    EXPECT_EQ(run("--json evidence complications " + data + " --rule " + out("evidence/rule.sql"))
                  .json()
                  .at("found_examinations"),
        4);
    std::ofstream(fs::path(data) / "oxygen.csv", std::ios::app) << "P1,yesterday\n";
    const CommandRun bad = run("--json evidence complications " + data);
    EXPECT_EQ(bad.exit_code, 2);
    EXPECT_NE(bad.error().find("yesterday"), std::string::npos) << bad.error();
    EXPECT_EQ(run("--json evidence complications " + data + " --skip-bad").json().at("bad_rows").at("count"), 1);
    EXPECT_EQ(run("evidence complications " + data + " --rule nowhere.sql").exit_code, 2);

    const std::string records = out("evidence/records.csv");
    ASSERT_EQ(run("evidence generate exposures --out " + records).exit_code, 0);
    const CommandRun rules
        = run("--json evidence rules " + records + " --exposures A,B,C --out " + out("evidence/rules"));
    ASSERT_EQ(rules.exit_code, 0) << rules.out;
    EXPECT_EQ(rules.json().at("rules").size(), 13u);
    for (const char* file : { "rules.csv", "rules.json", "rules.svg" })
        EXPECT_TRUE(fs::exists(fs::path(out("evidence/rules")) / file)) << file;
    EXPECT_EQ(run("evidence rules " + records + " --exposures D").exit_code, 2);
}

TEST_F(CommandLine, AnAccuracyIsReachedAndReported)
{
    const std::string plan = "--json plan " + case_file() + " --out " + out("accurate");
    // The widest bars that can be asked: the first mesh reaches them.
    const CommandRun wide = run(plan + " --accuracy 100%,20 --time 60");
    ASSERT_EQ(wide.exit_code, 0) << wide.out;
    const Json accuracy = wide.json().at("approaches").at(0).at("accuracy");
    EXPECT_EQ(accuracy.at("asked_force"), 1.0);
    EXPECT_EQ(accuracy.at("asked_opening"), 20.0);
    EXPECT_EQ(accuracy.at("asked_time"), 60.0);
    EXPECT_EQ(accuracy.at("ended_by"), "reached");
    EXPECT_EQ(accuracy.at("rounds"), 1);
    const Json bars = wide.json().at("approaches").at(0).at("error_estimate");
    EXPECT_EQ(accuracy.at("reached_opening"), bars.at("opening_width_mm"));
    const CommandRun none = run(plan + " --accuracy none");
    EXPECT_FALSE(none.json().at("approaches").at(0).contains("accuracy"));
    const CommandRun beyond = run(plan + " --accuracy 200%");
    EXPECT_NE(beyond.error().find("(option --accuracy)"), std::string::npos) << beyond.out;
}

TEST_F(CommandLine, AFormatThatCannotHoldAPlanDoesNotLoseThePlan)
{
    fs::copy(folder / "c", folder / "framed", fs::copy_options::recursive);
    const std::string file = (folder / "framed" / "case.json").string(), plans = out("framed_plan");
    ASSERT_EQ(run("approach add " + file
                  + " --name framed --points 1.3,0,-25 0.9,0,0 1.3,0,25 --target target --retract cavity --retractor "
                    "midcab --opening 10")
                  .exit_code,
        0);
    const CommandRun plan = run("--json plan " + file + " --approach framed --draft --export ccx,feb --out " + plans);
    EXPECT_EQ(plan.exit_code, 1) << plan.out;
    const Json document = plan.json();
    ASSERT_EQ(document.at("exports").size(), 1U);
    EXPECT_TRUE(fs::exists(document.at("exports").at(0).get<std::string>()));
    ASSERT_EQ(document.at("not_exported").size(), 1U);
    EXPECT_EQ(document.at("not_exported").at(0).at("format"), "feb");
    EXPECT_NE(document.at("not_exported").at(0).at("reason").get<std::string>().find("turn"), std::string::npos);
    EXPECT_TRUE(fs::exists(fs::path(plans) / "metrics.json"));
    EXPECT_FALSE(fs::exists(fs::path(plans) / "framed.feb"));
}

TEST_F(CommandLine, APlanThatIsNotToBeBelievedEndsWithOneAndIsWritten)
{
    // Coarse four-node elements under hooks: many drafts fail, and say so.
    for (const char* elasticity : { "linear", "corotational" }) {
        const CommandRun draft
            = run("--json plan " + case_file() + " --draft --elasticity " + elasticity + " --out " + out("doubtful"));
        std::ifstream file(fs::path(out("doubtful")) / "metrics.json");
        const Json field = Json::parse(file).at("approaches").at(0);
        const bool is_answer
            = field.at("volume_failures").at("believable").get<bool>() && field.at("mechanics_status") == "converged";
        EXPECT_EQ(draft.exit_code, is_answer ? 0 : 1) << elasticity << draft.out;
        EXPECT_EQ(draft.json().at("approaches").at(0).at("hook_force_N"), field.at("hook_force_N"));
    }
}

TEST_F(CommandLine, HowWoundsAreSolvedIsChosenInTheCaseOrByOption)
{
    std::ifstream in(case_file());
    const std::string kept { std::istreambuf_iterator<char>(in), {} };
    Json document = Json::parse(kept);
    document["solution"] = { { "elasticity", "hyperelastic" }, { "element", "locking-free" } };
    std::ofstream(case_file()) << document.dump(2);
    const std::string plan = "--json plan " + case_file() + " --accuracy none --out " + out("chosen");
    const CommandRun near = run(plan + " --element p1 --near 20"); // the elasticity stays the case's
    EXPECT_EQ(near.exit_code, 0) << near.out;
    const Json solution = near.json().at("approaches").at(0).at("solution");
    EXPECT_EQ(solution.at("elasticity"), "hyperelastic");
    EXPECT_EQ(solution.at("element"), "p1");
    EXPECT_EQ(solution.at("near_mm"), 20.0);
    EXPECT_EQ(solution.at("laws").at("fat"), "neo-Hookean");
    for (const char* contradiction : { " --near 20", " --element p1 --near 20 --contact",
             " --element p1 --near 20 --elasticity linear", " --check", " --draft --element p2" })
        EXPECT_EQ(run(plan + contradiction).exit_code, 2) << contradiction;
    EXPECT_EQ(run(plan + " --element p3").exit_code, 2);
    std::ofstream(case_file()) << kept;
}

TEST_F(CommandLine, TensionIsSetListedPlannedWithAndTakenOff)
{
    const std::string tension = "--json tension " + case_file();
    const auto skin = [&] {
        const Json listed = run(tension).json();
        for (const Json& tissue : listed.at("tension"))
            if (tissue.at("material") == "skin")
                return tissue.at("pre_strain").get<std::string>();
        return std::string("no skin");
    };
    EXPECT_EQ(skin(), "none");
    for (const char* wrong : { "--along 0.04", "--material skin", "--material skin --along 0.04",
             "--material skin --along 0.7 --direction 1,0,0", "--material skin --along nan --direction 1,0,0",
             "--material skin --along 0.04 --direction 0,0,0", "--material skin --along 0.04 --direction 1,0",
             "--material skin --along 0.04 --direction 1,0,0 --normal 2,0,0", "--material skin --none --along 0.1",
             "--material liver --along 0.04 --direction 1,0,0" })
        EXPECT_EQ(run(tension + " " + wrong).exit_code, 2) << wrong;
    EXPECT_NE(run(tension + " --material liver --none").error().find("skin"), std::string::npos) << "what there is";
    EXPECT_EQ(skin(), "none") << "what is refused changes nothing";
    ASSERT_EQ(run(tension + " --material skin --along 0.05 --across 0.02 --direction 1,0,0").exit_code, 0);
    EXPECT_EQ(skin(), "5.0 % along (1.000, 0.000, 0.000), 2.0 % across");
    const std::string plan
        = "--json plan " + case_file() + " --accuracy none --elasticity linear --out " + out("tense");
    EXPECT_EQ(run(plan + " --export feb").exit_code, 2);
    const Json planned = run(plan).json().at("approaches").at(0).at("tension");
    EXPECT_EQ(planned.at("tissues").at(0).at("material"), "skin");
    ASSERT_EQ(run(tension + " --material skin --none").exit_code, 0);
    EXPECT_EQ(skin(), "none");
    EXPECT_FALSE(run(plan).json().at("approaches").at(0).contains("tension"));
}

TEST_F(CommandLine, AssumedVesselsAreSetListedAndTakenOut)
{
    std::stringstream before;
    before << std::ifstream(case_file()).rdbuf();
    const std::string vessels = "--json vessels " + case_file();
    EXPECT_TRUE(run(vessels).json().at("assumed_vessels").empty());
    for (const char* wrong : { "--set a", "--points 0,0,0 1,0,0", "--set a --points 0,0,0", "--set a --points 0,0 1,0",
             "--set a --points 0,0,nan 1,0,0", "--set a --points 0,0,0 1,0,0 --radius 0", "--radius 2", "--remove a",
             "--set target --points 0,0,0 1,0,0" })
        EXPECT_EQ(run(vessels + " " + wrong).exit_code, 2) << wrong;
    const CommandRun no_bones = run(vessels + " --assume");
    EXPECT_EQ(no_bones.exit_code, 2);
    EXPECT_NE(no_bones.error().find("spine"), std::string::npos) << "what is missing: " << no_bones.error();
    EXPECT_TRUE(run(vessels).json().at("assumed_vessels").empty()) << "what is refused changes nothing";
    ASSERT_EQ(run(vessels + " --set artery --points -40,0,0 0,0,0 40,0,5 --radius 1.5").exit_code, 0);
    ASSERT_EQ(run(vessels + " --set artery --radius 2").exit_code, 0);
    const Json listed = run(vessels).json().at("assumed_vessels");
    ASSERT_EQ(listed.size(), 1U);
    EXPECT_EQ(listed[0].at("name"), "artery");
    EXPECT_EQ(listed[0].at("radius_mm"), 2.0);
    EXPECT_EQ(listed[0].at("line_mm").size(), 3U);
    ASSERT_EQ(run(vessels + " --remove artery").exit_code, 0);
    EXPECT_TRUE(run(vessels).json().at("assumed_vessels").empty());
    std::ofstream(case_file()) << before.str();
}

TEST_F(CommandLine, PressureIsPlannedWithAndRefusedByName)
{
    const std::string plan
        = "--json plan " + case_file() + " --accuracy none --elasticity linear --out " + out("pressed");
    for (const char* wrong :
        { "cavity", "cavity=", "cavity=nan", "cavity=inf", "cavity=-200", "cavity=2000", "nobody=1", "skin=1",
            "cavity=1 --pressure cavity=2", "cavity=1 --export feb", "cavity=1 --elasticity corotational --near 30" })
        EXPECT_EQ(run(plan + " --pressure " + wrong).exit_code, 2) << wrong;
    EXPECT_NE(run(plan + " --pressure nobody=1").error().find("there is no label \"nobody\""), std::string::npos);
    EXPECT_FALSE(fs::exists(out("pressed")));
    const Json planned = run(plan + " --pressure cavity=0.2").json();
    EXPECT_EQ(planned.at("computed").at("pressures").at(0).at("label"), "cavity");
    const Json pressure = planned.at("approaches").at(0).at("pressures").at(0);
    EXPECT_EQ(pressure.at("pressure_kPa"), 0.2);
    EXPECT_FALSE(pressure.at("follows_surface"));
    EXPECT_LT(pressure.at("force_N").at(1).get<double>(), -1.0) << "outward";
    const auto metrics = [&] {
        std::ifstream file(fs::path(out("pressed")) / "metrics.json");
        return std::string(std::istreambuf_iterator<char>(file), {});
    };
    const std::string before = metrics();
    EXPECT_NE(before.find("pressures"), std::string::npos);
    const CommandRun apart = run(plan + " --pressure target=1");
    EXPECT_EQ(apart.exit_code, 2);
    EXPECT_NE(apart.error().find("does not border on \"target\""), std::string::npos);
    EXPECT_EQ(metrics(), before) << "what is refused changes nothing";
}

TEST_F(CommandLine, ImplausibleNumbersAreRefusedWithTheUnitThatExplainsThem)
{
    std::ifstream in(case_file());
    Json changed = Json::parse(in);
    const std::string slipped = (folder / "c" / "slipped.json").string();
    const auto write = [&] { std::ofstream(slipped) << changed.dump(); };
    for (Json& material : changed.at("materials"))
        if (material.at("name") == "skin")
            material.at("youngs_modulus_MPa") = 200.0; // kPa
    write();
    const CommandRun refused = run("--json plan " + slipped + " --out " + out("slipped"));
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_NE(refused.error().find("is it in kPa (0.2 MPa)?"), std::string::npos) << refused.out;
    EXPECT_NE(refused.json().at("where").get<std::string>().find("youngs_modulus_MPa"), std::string::npos)
        << refused.out;
    EXPECT_FALSE(fs::exists(out("slipped")));
    changed["accept_implausible"] = true;
    write();
    const Json planned = run("--json plan " + slipped + " --draft --elasticity linear --out " + out("slipped")).json();
    const Json& field = planned.at("approaches").at(0);
    EXPECT_NE(field.at("implausible").at(0).get<std::string>().find("skin is 200 MPa"), std::string::npos) << field;
    EXPECT_EQ(field.at("solution").at("draft"), true);
    EXPECT_GE(field.at("solution").at("mesh").at("corridor_edge_mm").get<double>(), 8.0);
    // A depth in metres is refused where it is written.
    const std::string in_metres = "--json approach add " + case_file()
        + " --name metres --points 1.3,0,-25 1.3,0,25 --depth 0.03 --target target";
    EXPECT_EQ(run(in_metres).exit_code, 2);
    EXPECT_NE(run(in_metres).error().find("is it in m (30 mm)?"), std::string::npos) << run(in_metres).out;
}

TEST_F(CommandLine, RenderDrawsTheViewsAndReadsTheCtForItsSlices)
{
    const CommandRun render
        = run("--json --profile render " + case_file() + " --out " + out("render") + " --size 320x240");
    ASSERT_EQ(render.exit_code, 0);
    EXPECT_EQ(render.json().at("pictures").size(), 3u);
    for (const Json document = render.json(); const Json& picture : document.at("pictures"))
        EXPECT_GT(fs::file_size(picture.at("file").get<std::string>()), 5000u);
    EXPECT_TRUE(parts_of(render.json()).count("voxels"));
}

TEST_F(CommandLine, ASceneWithoutACtBuildsNoVolume)
{
    const fs::path bare = folder / "bare";
    fs::create_directories(bare);
    for (const char* file : { "labels.nrrd", "labels.labels.json" })
        fs::copy_file(folder / "c" / file, bare / file, fs::copy_options::overwrite_existing);
    std::ifstream in(case_file());
    Json document = Json::parse(in);
    document.erase("ct");
    std::ofstream(bare / "case.json") << document.dump(2);
    const CommandRun render = run("--json --profile render " + (bare / "case.json").string() + " --out "
        + out("bare_pictures") + " --size 320x240");
    ASSERT_EQ(render.exit_code, 0);
    const auto parts = parts_of(render.json());
    EXPECT_TRUE(parts.count("renderer"));
    EXPECT_FALSE(parts.count("voxels"));
    EXPECT_FALSE(parts.count("volume rendering"));
    EXPECT_EQ(render.json().at("pictures").size(), 2u); // no slices without an image
}

TEST_F(CommandLine, ApproachesAreListedAndRemoved)
{
    const std::string add = "approach add " + case_file() + " --points 1,0,-20 1,0,20 --target target --name second";
    ASSERT_EQ(run(add).exit_code, 0);
    EXPECT_EQ(run(add).exit_code, 2); // the name is taken
    EXPECT_EQ(run("--json approach list " + case_file()).json().at("approaches").size(), 2u);
    EXPECT_EQ(run("approach remove " + case_file() + " --name second").exit_code, 0);
    EXPECT_EQ(run("--json approach list " + case_file()).json().at("approaches").size(), 1u);
    EXPECT_EQ(run("approach add " + case_file() + " --template median --target target").exit_code, 2); // no sternum
}

TEST_F(CommandLine, TheStepsOfTheCrankAreChosenAndListed)
{
    const std::string add = "--json approach add " + case_file()
        + " --points 1,0,-20 1,0,20 --target target --name turned --hooks 2 --opening 10";
    const Json added = run(add).json();
    EXPECT_FALSE(added.contains("opening_protocol")); // the default
    const Json slower
        = run("--json hooks " + case_file() + " --approach turned --template 2 --opening 10 --turn-every 30").json();
    EXPECT_EQ(slower.at("opening_protocol"), "half a turn of the crank (7 mm) every 30 s");
    // Other hooks keep the steps.
    ASSERT_EQ(run("hooks " + case_file() + " --approach turned --template 2 --opening 12").exit_code, 0);
    EXPECT_NE(run("approach list " + case_file()).out.find("opened by half a turn of the crank (7 mm) every 30 s"),
        std::string::npos);
    EXPECT_EQ(run("approach remove " + case_file() + " --name turned").exit_code, 0);
}

TEST_F(CommandLine, TheDivisionOfAnApproachIsChosenAndListed)
{
    const std::string add = "approach add " + case_file() + " --points 1,0,-20 1,0,20 --target target --name divided ";
    EXPECT_EQ(run(add + "--division half").exit_code, 2);
    EXPECT_EQ(run(add + "--forwards 20").exit_code, 2); // a distance goes with full division
    ASSERT_EQ(run(add).exit_code, 0);
    const auto division = [] {
        const Json listed = run("--json approach list " + case_file()).json();
        return listed.at("approaches").back().at("division");
    };
    EXPECT_EQ(division().at("extent"), "skin"); // as points have it
    const std::string divide = "approach divide " + case_file() + " --name divided ";
    EXPECT_EQ(run(divide).exit_code, 2); // the extent is missing
    ASSERT_EQ(run(divide + "--division full --forwards 20").exit_code, 0);
    EXPECT_EQ(division().at("extent"), "full");
    EXPECT_DOUBLE_EQ(division().at("forwards_mm").get<double>(), 20.0);
    EXPECT_NE(
        run("approach list " + case_file()).out.find("forwards 20 mm, backwards as far as is safe"), std::string::npos);
    ASSERT_EQ(run(divide + "--division skin").exit_code, 0);
    EXPECT_FALSE(division().contains("forwards_mm"));
    EXPECT_EQ(run("approach divide " + case_file() + " --name nobody --division skin").exit_code, 2);
    EXPECT_EQ(run("approach remove " + case_file() + " --name divided").exit_code, 0);
}

TEST_F(CommandLine, BothDivisionsAreAddedSideBySide)
{
    const Json added = run("--json approach add " + case_file()
        + " --points 1,0,-20 1,0,20 --target target --name divided --division both --backwards 15 --hooks 2 --opening "
          "10")
                           .json();
    ASSERT_EQ(added.at("approaches").size(), 2U);
    const Json &full = added.at("approaches")[0], &skin = added.at("approaches")[1];
    EXPECT_EQ(full.at("name"), "divided");
    EXPECT_EQ(full.at("division").at("extent"), "full");
    EXPECT_DOUBLE_EQ(full.at("division").at("backwards_mm").get<double>(), 15.0);
    EXPECT_EQ(skin.at("name"), "divided_skin");
    EXPECT_EQ(skin.at("division"), (Json { { "extent", "skin" } }));
    EXPECT_EQ(skin.at("hooks"), 2);
    EXPECT_EQ(full.at("hooks"), 2);
    for (const char* name : { "divided", "divided_skin" })
        EXPECT_EQ(run("approach remove " + case_file() + " --name " + name).exit_code, 0);
    // An extent is one of an existing approach.
    EXPECT_EQ(run("approach divide " + case_file() + " --name nobody --division both").exit_code, 2);
}

TEST_F(CommandLine, AblationsAreAddedListedAndCut)
{
    const std::string add = "--json approach add " + case_file()
        + " --points 1.3,0,-25 1.3,0,25 --target target --retract cavity --name taken ";
    const CommandRun added
        = run(add + "--ablate fat:-6,5:10,40 --ablate ball:1,2,0,9 --loose removed --hooks 2 --opening 10");
    ASSERT_EQ(added.exit_code, 0) << added.out;
    const Json ablations = added.json().at("ablations");
    ASSERT_EQ(ablations.size(), 2u);
    EXPECT_EQ(ablations[0],
        Json::parse(R"({"label": "fat", "from_mm": -6.0, "to_mm": 5.0, "along_from_mm": 10.0, "along_to_mm": 40.0})"));
    EXPECT_EQ(ablations[1], Json::parse(R"({"centre_mm": [1.0, 2.0, 0.0], "radius_mm": 9.0})"));
    const std::string listed = run("approach list " + case_file()).out;
    for (const char* line : { "removes fat from -6.0 to 5.0 mm across and 10.0 to 40.0 mm along the incision",
             "removes tissue in a ball of 9.0 mm at (1, 2, 0)", "loose pieces are removed" })
        EXPECT_NE(listed.find(line), std::string::npos) << listed;

    const std::string rest = case_file() + " --approach taken --out " + out("taken");
    const CommandRun cut = run("cut " + rest);
    ASSERT_EQ(cut.exit_code, 0) << cut.out;
    EXPECT_NE(cut.out.find("taken out: fat from -6.0 to 5.0 mm across"), std::string::npos) << cut.out;
    EXPECT_NE(cut.out.find(" cm3 of skin"), std::string::npos) << cut.out;
    EXPECT_EQ(cut.out.find("e+"), std::string::npos) << cut.out;
    const CommandRun plan = run("plan --accuracy none " + rest);
    ASSERT_EQ(plan.exit_code, 0) << plan.out;
    EXPECT_NE(plan.out.find("cm2 at rest) is not part of the opening"), std::string::npos) << plan.out;
    std::ifstream metrics(fs::path(out("taken")) / "metrics.json");
    const Json field = Json::parse(metrics).at("approaches").at(0);
    // The ball's section with the skin, less what whole elements make of it.
    EXPECT_NEAR(field.at("removed_skin_mm2").get<double>(), 3.14 * (81.0 - 4.0), 120.0);

    const fs::path earlier = fs::path(out("taken")) / "metrics-earlier.json";
    EXPECT_FALSE(fs::exists(earlier));
    Json of_two { { "approaches", { field, field } } };
    of_two["approaches"][1]["name"] = "other";
    std::ofstream(fs::path(out("taken")) / "metrics.json") << of_two;
    const CommandRun again = run("plan --accuracy none " + rest);
    EXPECT_NE(again.out.find("metrics-earlier.json keeps the earlier results of other"), std::string::npos)
        << again.out;
    std::ifstream kept(earlier);
    EXPECT_EQ(Json::parse(kept, nullptr, false), of_two);
    std::ofstream(fs::path(out("taken")) / "metrics.json") << of_two;
    EXPECT_EQ(Json::parse(run("plan --accuracy none " + rest + " --json").out).at("earlier_results"), earlier.string());
    EXPECT_EQ(run("approach remove " + case_file() + " --name taken").exit_code, 0);

    const std::map<std::string, std::string> refused {
        { "spleen:-5,5", "there is no label \"spleen\"; the wall has: skin, fat, muscle" },
        { "cavity:-5,5",
            "only tissue of the wall can be removed, and \"cavity\" is not part of the wall; the wall has: skin, fat, "
            "muscle" },
        { "fat:5,5", "across the incision, FROM must be less than TO" },
        { "fat:-5,5:30,20", "along the incision, FROM must be less than TO" },
        { "fat:-5,5:0,90", "positions along the incision are 0 to " },
        { "fat:nan,5", "\"nan\" in \"nan,5\" is not a number" },
        { "fat:1,2,3", "\"1,2,3\" must be 2 numbers" },
        { "fat", "give LABEL:FROM,TO" },
        { "ball:0,0,0,0", "the radius of a ball must be positive" },
        { "ball:0,0,nan,5", "\"nan\" in" },
        { "ball:0,0,0,5:spleen", "there is no label \"spleen\"" },
    };
    for (const auto& [text, message] : refused) {
        const CommandRun bad = run(add + "--ablate " + text);
        EXPECT_EQ(bad.exit_code, 2) << text;
        EXPECT_EQ(bad.error().find(message), 0u) << bad.out;
        EXPECT_EQ(bad.json().at("where"), "--ablate " + text);
    }
    EXPECT_EQ(run(add + "--loose floating").exit_code, 2);
    EXPECT_EQ(run("--json approach list " + case_file()).json().at("approaches").size(), 1u);
}

TEST_F(CommandLine, AClosedIncisionIsRefusedByItsPoints)
{
    const CommandRun closed = run("--json approach add " + case_file()
        + " --name closed --target target --points -20,0,-20 20,0,-20 20,0,20 -20,0,20 -20,0,-20");
    EXPECT_EQ(closed.exit_code, 2);
    EXPECT_NE(closed.error().find("an incision does not close"), std::string::npos) << closed.out;
    EXPECT_NE(closed.error().find("before its first point (option"), std::string::npos) << closed.out;
    EXPECT_EQ(closed.json().at("where"), "point 5");
}

TEST_F(CommandLine, RefusalsNameTheOptionsOfTheirOwnCommand)
{
    // A library names the field; the same field is another option elsewhere, or none.
    const CommandRun added = run("--json approach add " + case_file()
        + " --name hooked --target target --points 1.3,0,-25 0.9,0,0 1.3,0,25 --opening 20 --hooks 3");
    EXPECT_EQ(added.exit_code, 2);
    EXPECT_NE(added.error().find("use 2, 4, 8 or blade (option --hooks)"), std::string::npos) << added.out;
    const CommandRun hooked = run("--json hooks " + case_file() + " --approach straight --template 3 --opening 20");
    EXPECT_EQ(hooked.exit_code, 2);
    EXPECT_NE(hooked.error().find("use 2, 4, 8 or blade (option --template)"), std::string::npos) << hooked.out;
    EXPECT_EQ(hooked.json().at("where"), "hook template");
    const CommandRun both
        = run("--json plan " + case_file() + " --near 30 --contact --approach straight --out " + out("both"));
    EXPECT_EQ(both.exit_code, 2);
    EXPECT_NE(
        both.error().find("let contact be auto, or remove near_mm (options --near, --contact)"), std::string::npos)
        << both.out;
}

TEST_F(CommandLine, MisspeltWordsAreNamedWithTheNearestKnown)
{
    const CommandRun command = run("--json plna " + case_file());
    EXPECT_EQ(command.exit_code, 2);
    EXPECT_EQ(command.error(), "unknown command 'plna': did you mean 'plan'?");
    // --out is missing as well; the misspelt word comes first.
    const CommandRun option = run("--json approach add " + case_file() + " --opning 30");
    EXPECT_EQ(option.exit_code, 2);
    EXPECT_EQ(option.error(), "approach add: unknown option '--opning': did you mean '--opening'?");
    EXPECT_EQ(option.json().at("where"), "command line");
    const CommandRun text
        = retractor::test_support::run_line(std::string(RETRACTOR_PROGRAM) + " plan --opning 30 2>&1");
    EXPECT_NE(text.out.find("retractor: plan: unknown option '--opning'"), std::string::npos) << text.out;
}

/// The doctor's checks by name.
std::map<std::string, Json> checks_of(const Json& document)
{
    std::map<std::string, Json> checks;
    for (const Json& check : document.at("checks"))
        checks[check.at("name").get<std::string>()] = check;
    return checks;
}

TEST_F(CommandLine, DoctorFindsWhatTheseTestsNeed)
{
    const CommandRun doctor = run("--json doctor");
    EXPECT_EQ(doctor.exit_code, 0);
    EXPECT_TRUE(doctor.json().at("can_run").get<bool>());
    const auto checks = checks_of(doctor.json());
    for (const char* name : { "sparse solver", "DICOM uncompressed", "DICOM JPEG lossless", "DICOM JPEG 2000",
             "DICOM RLE", "DICOM JPEG-LS", "NRRD", "NIfTI", "MetaImage", "osmesa", "egl" })
        EXPECT_EQ(checks.at(name).at("status"), "ok") << checks.at(name);
    EXPECT_NE(checks.at("BLAS").at("found").get<std::string>().find("libopenblas"), std::string::npos);
    for (const auto& [name, check] : checks)
        EXPECT_TRUE(check.at("status") == "ok" || !check.at("advice").get<std::string>().empty()) << check;
}

TEST_F(CommandLine, DoctorSaysWhatIsMissing)
{
    // A program alone in a folder has neither the other kind of context nor a window.
    const fs::path alone = folder / "alone" / "retractor";
    fs::create_directories(alone.parent_path());
    fs::copy_file(RETRACTOR_PROGRAM, alone, fs::copy_options::overwrite_existing);
    const CommandRun by_itself = run_program(alone.string() + " --json doctor");
    EXPECT_EQ(by_itself.exit_code, 0);
    EXPECT_EQ(checks_of(by_itself.json()).at("egl").at("status"), "missing");
    EXPECT_EQ(checks_of(by_itself.json()).at("retractor-workstation").at("status"), "missing");
    // Where no file can be written, no image can be read back: the main job cannot run.
    const CommandRun stuck = run_program("TMPDIR=/proc " + std::string(RETRACTOR_PROGRAM) + " --json doctor");
    EXPECT_EQ(stuck.exit_code, 1);
    EXPECT_FALSE(stuck.json().at("can_run").get<bool>());
    EXPECT_EQ(checks_of(stuck.json()).at("NRRD").at("status"), "missing");
}

TEST_F(CommandLine, DamagedBytesInMessagesStayOneJsonDocument)
{
    const fs::path bad = folder / "bad" / "case.json";
    fs::create_directories(bad.parent_path());
    std::ofstream(bad, std::ios::binary) << "{\"schema\xff\xfe\": 1}";
    const CommandRun run_bad = run("--json plan " + bad.string() + " --out " + out("x"));
    EXPECT_EQ(run_bad.exit_code, 2);
    EXPECT_FALSE(run_bad.json().at("error").get<std::string>().empty());
    EXPECT_NE(run_bad.json().at("where").get<std::string>().find("case.json#/"), std::string::npos);
}

} // namespace command_line_test
