// What the user meets when importing: the built executable is run on small phantoms, its output and files are read.

#include "datasets/dicom/dicom.h"
#include "datasets/io/label_table.h"
#include "datasets/io/volume_io.h"
#include "datasets/phantoms/phantom.h"
#include "tests/support/command_run.h"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <string>
#include <vector>

namespace retractor::ui {
namespace import_test {

    namespace fs = std::filesystem;
    using Json = nlohmann::json;

    /// @param with_errors standard error as well
    test_support::CommandRun run(const std::string& arguments, bool with_errors = false)
    {
        return test_support::run_line(
            std::string(RETRACTOR_PROGRAM) + " " + arguments + (with_errors ? " 2>&1" : " 2>/dev/null"));
    }

    std::string lower(std::string text)
    {
        for (char& c : text)
            c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
        return text;
    }

    std::string content_of(const fs::path& file)
    {
        std::ifstream stream(file, std::ios::binary);
        return { std::istreambuf_iterator<char>(stream), {} };
    }

    /// Files below `folder` that hold `text`, in any case, in their names or bytes.
    std::vector<std::string> files_with(const fs::path& folder, const std::string& text)
    {
        std::vector<std::string> found;
        for (const auto& entry : fs::recursive_directory_iterator(folder))
            if (entry.is_regular_file()
                && (lower(content_of(entry.path())).find(lower(text)) != std::string::npos
                    || lower(entry.path().string()).find(lower(text)) != std::string::npos))
                found.push_back(entry.path().filename().string());
        return found;
    }

    constexpr const char* kFamily = "Musterfrau";
    constexpr const char* kGiven = "Wilhelmine"; // long enough not to stand in the letters of a picture by chance
    constexpr const char* kId = "KH-4711-0815";

    /// A block phantom, as a DICOM series that names a patient and as NRRD, made once for all tests.
    class Import : public testing::Test {
    protected:
        static void SetUpTestSuite()
        {
            folder = fs::path(testing::TempDir()) / "import_command";
            fs::remove_all(folder);
            fs::create_directories(folder / "in");
            datasets::BlockParameters parameters;
            parameters.size_mm = { 80.0, 70.0, 80.0 };
            parameters.bone_bar = true;
            phantom = datasets::make_block_phantom(parameters);
            datasets::write_volume(folder / "in" / "ct.nrrd", phantom.ct);
            datasets::write_label_volume(folder / "in" / "labels.nrrd", phantom.labels);
            datasets::DicomOptions named;
            named.patient_name = std::string(kFamily) + "^" + kGiven;
            named.patient_id = kId;
            named.series_description = std::string("Thorax of ") + kFamily;
            datasets::write_dicom_series(folder / "dicom", phantom.ct, named);
        }
        static std::string in(const char* name) { return (folder / "in" / name).string(); }
        static std::string at(const std::string& name) { return (folder / name).string(); }
        static std::string with_labels() { return in("ct.nrrd") + " --labels " + in("labels.nrrd"); }
        static inline fs::path folder;
        static inline datasets::Phantom phantom;
    };

    TEST_F(Import, SaysWhatItFound)
    {
        const test_support::CommandRun import
            = run("--json import " + with_labels() + " --out " + at("said/case.json"));
        ASSERT_EQ(import.exit_code, 0);
        const Json document = import.json();
        EXPECT_EQ(document.at("frame"), "LPS");
        EXPECT_EQ(document.at("ct").at("size").at(0), phantom.ct.grid.size[0]);
        EXPECT_LT(document.at("ct").at("hu").at("min").get<int>(), document.at("ct").at("hu").at("max").get<int>());
        ASSERT_EQ(document.at("labels").size(), phantom.labels.table.size());
        for (const Json& label : document.at("labels")) {
            const auto id = label.at("id").get<Label>();
            const auto voxels = std::count(phantom.labels.voxels.begin(), phantom.labels.voxels.end(), id);
            EXPECT_EQ(label.at("voxels").get<std::ptrdiff_t>(), voxels);
            EXPECT_DOUBLE_EQ(label.at("volume_ml").get<double>(),
                static_cast<double>(voxels) * phantom.labels.grid.voxel_volume() / 1000.0);
        }
        EXPECT_TRUE(document.at("warnings").empty()) << document.at("warnings");
        EXPECT_GT(fs::file_size(document.at("contact_sheet").get<std::string>()), 20000u);
        EXPECT_TRUE(fs::exists(folder / "said" / "contact_sheet.png"));

        const test_support::CommandRun text
            = run("import " + with_labels() + " --no-contact-sheet --out " + at("plain/case.json"));
        EXPECT_NE(text.out.find("skin"), std::string::npos);
        EXPECT_FALSE(fs::exists(folder / "plain" / "contact_sheet.png"));
    }

    TEST_F(Import, WithoutLabelsTellsTheTwoWaysToGetThem)
    {
        const test_support::CommandRun import
            = run("--json import " + in("ct.nrrd") + " --out " + at("none/case.json"));
        EXPECT_EQ(import.exit_code, 2);
        const std::string error = import.json().at("error");
        EXPECT_NE(error.find("--labels"), std::string::npos);
        EXPECT_NE(error.find("--autosegment"), std::string::npos);
        EXPECT_FALSE(fs::exists(folder / "none"));
    }

    TEST_F(Import, WrongInputAndOptionsExitWithTwoAndSayWhere)
    {
        std::ofstream(folder / "in" / "text.nrrd") << "no image";
        fs::create_directories(folder / "in" / "empty");
        const std::string out = " --out " + at("wrong/case.json");
        for (const std::string& arguments : {
                 with_labels(), // no --out
                 with_labels() + " --out " + at("wrong/patient.nrrd"), // the name of an image
                 with_labels() + " --out " + at("wrong/patient.labels.json"), // that of a label table
                 with_labels() + " --out " + at("wrong/metrics.json"), // that of what plan writes
                 with_labels() + " --out " + at("in"), // a folder
                 in("ct.nrrd") + " --autosegment --preset totalsegmentator" + out,
                 in("ct.nrrd") + " --autosegment --repair-labels" + out,
                 with_labels() + " --spacing 2" + out,
                 in("ct.nrrd") + " --autosegment --spacing 9" + out,
                 with_labels() + " --preset nobody" + out,
                 with_labels() + " --series 3" + out,
                 with_labels() + " --with-identity" + out,
                 with_labels() + " --list-series",
                 in("ct.nrrd") + " --list-series",
                 in("empty") + " --list-series",
                 in("ct.nrrd") + " --labels " + in("ct.nrrd") + out, // no table beside it
                 in("text.nrrd") + " --labels " + in("labels.nrrd") + out,
                 in("nothing.nrrd") + " --labels " + in("labels.nrrd") + out,
                 at("dicom") + " --series 99 --labels " + in("labels.nrrd") + out,
             }) {
            const test_support::CommandRun import = run("--json import " + arguments);
            EXPECT_EQ(import.exit_code, 2) << arguments;
            ASSERT_TRUE(Json::accept(import.out)) << arguments << "\n" << import.out;
            EXPECT_FALSE(import.json().at("error").get<std::string>().empty()) << arguments;
            EXPECT_TRUE(import.json().contains("where")) << arguments;
        }
        EXPECT_FALSE(fs::exists(folder / "wrong"));
    }

    TEST_F(Import, LabelsElsewhereAreRefusedAndAnExistingCaseStays)
    {
        const std::string out = " --no-contact-sheet --out " + at("kept/case.json");
        ASSERT_EQ(run("import " + with_labels() + out).exit_code, 0);
        const std::string before = content_of(folder / "kept" / "case.json");
        mesh::LabelVolume away = phantom.labels;
        away.grid.origin.x() += 5000.0;
        datasets::write_label_volume(folder / "in" / "away.nrrd", away);
        const test_support::CommandRun import
            = run("--json import " + in("ct.nrrd") + " --labels " + in("away.nrrd") + out);
        EXPECT_EQ(import.exit_code, 2);
        EXPECT_NE(import.json().at("error").get<std::string>().find("inside the CT"), std::string::npos);
        EXPECT_EQ(content_of(folder / "kept" / "case.json"), before);
    }

    TEST_F(Import, PlannedApproachesAreReplacedOnlyWhenAsked)
    {
        const std::string case_file = at("planned/case.json");
        const std::string import = "--json import " + with_labels() + " --no-contact-sheet --out " + case_file;
        ASSERT_EQ(run(import).exit_code, 0);
        ASSERT_EQ(run(import).exit_code, 0); // nothing planned yet
        ASSERT_EQ(
            run("approach add " + case_file + " --name a --points 1.3,0,-25 1.3,0,25 --target target").exit_code, 0);
        const std::string before = content_of(folder / "planned" / "case.json");
        const test_support::CommandRun refused = run(import);
        EXPECT_EQ(refused.exit_code, 2);
        EXPECT_EQ(refused.json().at("where"), case_file);
        const std::string error = refused.json().at("error");
        EXPECT_NE(error.find("1 planned approach"), std::string::npos) << error;
        EXPECT_NE(error.find("--replace"), std::string::npos) << error;
        EXPECT_EQ(content_of(folder / "planned" / "case.json"), before);
        ASSERT_EQ(run(import + " --replace").exit_code, 0);
        EXPECT_NE(content_of(folder / "planned" / "case.json"), before);
    }

    TEST_F(Import, AFileThatIsNoCaseIsReplacedOnlyWhenAsked)
    {
        fs::create_directories(folder / "foreign");
        const std::string notes = at("foreign/notes.json"), text = "{ \"mine\": 1 }";
        std::ofstream(notes) << text;
        const std::string import = "--json import " + with_labels() + " --no-contact-sheet --out " + notes;
        const test_support::CommandRun refused = run(import);
        EXPECT_EQ(refused.exit_code, 2);
        EXPECT_EQ(refused.json().at("where"), notes);
        EXPECT_EQ(content_of(notes), text);
        EXPECT_EQ(run(import + " --replace").exit_code, 0);
        EXPECT_EQ(run("approach list " + notes).exit_code, 0);
    }

    TEST_F(Import, LongNamesAreListedWhole)
    {
        mesh::LabelVolume labels = phantom.labels;
        const std::string name(700, 'n');
        labels.table.front().name = name;
        datasets::write_label_volume(folder / "in" / "long.nrrd", labels);
        const test_support::CommandRun import = run("import " + in("ct.nrrd") + " --labels " + in("long.nrrd")
            + " --no-contact-sheet --out " + at("long/case.json"));
        ASSERT_EQ(import.exit_code, 0) << import.out;
        const std::size_t row = import.out.find(name);
        ASSERT_NE(row, std::string::npos);
        const std::string rest = import.out.substr(row + name.size(), import.out.find('\n', row) - row - name.size());
        EXPECT_NE(rest.find(labels.table.front().material), std::string::npos) << rest;
    }

    TEST_F(Import, FragmentsAreToldAndRepairedOnlyWhenAsked)
    {
        mesh::LabelVolume broken = phantom.labels;
        const mesh::LabelInfo* target = mesh::find_label(broken.table, "target");
        const std::size_t stray = broken.grid.offset(8, 30, 8);
        broken.voxels[stray] = target->id;
        datasets::write_label_volume(folder / "in" / "broken.nrrd", broken);
        const std::string import
            = "--json import " + in("ct.nrrd") + " --labels " + in("broken.nrrd") + " --no-contact-sheet --out ";
        const Json told = run(import + at("broken/case.json")).json();
        ASSERT_EQ(told.at("fragments").size(), 1u) << told.at("fragments");
        EXPECT_EQ(told.at("fragments").at(0).at("name"), "target");
        EXPECT_EQ(told.at("fragments").at(0).at("stray_voxels"), 1);
        EXPECT_TRUE(told.at("repaired").empty());
        EXPECT_EQ(datasets::read_label_volume(folder / "broken" / "labels.nrrd").voxels[stray], target->id);
        const Json mended = run(import + at("mended/case.json") + " --repair-labels").json();
        EXPECT_TRUE(mended.at("fragments").empty()) << mended.at("fragments");
        EXPECT_FALSE(mended.at("repaired").empty());
        EXPECT_EQ(datasets::read_label_volume(folder / "mended" / "labels.nrrd").voxels, phantom.labels.voxels);
    }

    TEST_F(Import, SeriesAreListedAndNothingElseIsDone)
    {
        const test_support::CommandRun list = run("--json import " + at("dicom") + " --list-series", true);
        ASSERT_EQ(list.exit_code, 0) << list.out;
        ASSERT_EQ(list.json().at("series").size(), 1u);
        EXPECT_EQ(list.json().at("series").at(0).at("frames"), phantom.ct.grid.size[2]);
        EXPECT_EQ(list.json().at("series").at(0).at("kind"), ""); // no localizer, no secondary capture
        EXPECT_NE(run("import " + at("dicom") + " --list-series").out.find(" slices "), std::string::npos);
        EXPECT_EQ(list.out.find(kFamily), std::string::npos); // in the description of the series
    }

    TEST_F(Import, NameAndIdGoNowhere)
    {
        std::string said;
        const auto step = [&](const std::string& arguments) {
            const test_support::CommandRun command = run(arguments, true);
            EXPECT_EQ(command.exit_code, 0) << arguments << "\n" << command.out;
            said += command.out;
        };
        const std::string case_file = at("private/case.json");
        step("import " + at("dicom") + " --labels " + in("labels.nrrd") + " --out " + case_file);
        step("--json import " + at("dicom") + " --labels " + in("labels.nrrd") + " --out " + case_file);
        step("approach add " + case_file
            + " --name a --points 1.3,0,-25 1.3,0,25 --target target --retract cavity --hooks 2 --opening 20");
        step("plan " + case_file + " --accuracy none --element p1 --render --out " + at("private/plan"));
        step("render " + case_file + " --views slices --out " + at("private/pictures"));
        ASSERT_TRUE(fs::exists(folder / "private" / "plan" / "report.html"));
        for (const char* secret : { kFamily, kGiven, kId }) {
            EXPECT_TRUE(files_with(folder / "private", secret).empty()) << secret;
            EXPECT_EQ(lower(said).find(lower(secret)), std::string::npos) << secret;
        }
        EXPECT_FALSE(files_with(folder / "dicom", kFamily).empty()); // or the search finds nothing anywhere
    }

    TEST_F(Import, IdentityIsKeptInTheCaseFileAloneWhenAsked)
    {
        const test_support::CommandRun import = run("--json import " + at("dicom") + " --labels " + in("labels.nrrd")
                + " --with-identity --out " + at("named/case.json"),
            true);
        ASSERT_EQ(import.exit_code, 0) << import.out;
        EXPECT_EQ(import.out.find(kFamily), std::string::npos);
        EXPECT_EQ(files_with(folder / "named", kFamily), std::vector<std::string> { "case.json" });
        const Json written = Json::parse(content_of(folder / "named" / "case.json"));
        EXPECT_EQ(written.at("patient").at("name"), std::string(kFamily) + "^" + kGiven);
        EXPECT_EQ(written.at("patient").at("id"), kId);
        EXPECT_EQ(run("approach list " + at("named/case.json")).exit_code, 0); // and it is read again
    }

    TEST_F(Import, DicomInsideTheCaseFolderIsConvertedAndWarnedOf)
    {
        fs::create_directories(folder / "inside");
        fs::copy(folder / "dicom", folder / "inside" / "ct", fs::copy_options::recursive);
        const test_support::CommandRun import = run("--json import " + at("inside/ct") + " --labels "
            + in("labels.nrrd") + " --no-contact-sheet --out " + at("inside/case.json"));
        ASSERT_EQ(import.exit_code, 0);
        ASSERT_EQ(import.json().at("warnings").size(), 1u);
        EXPECT_NE(import.json().at("warnings").at(0).get<std::string>().find("name and id"), std::string::npos);
        EXPECT_EQ(Json::parse(content_of(folder / "inside" / "case.json")).at("ct").at("path"), "ct.nrrd");
    }

    TEST_F(Import, LabelsThatTheCtContradictsAreWarnedOf)
    {
        mesh::LabelVolume wrong = phantom.labels;
        for (mesh::LabelInfo& info : wrong.table)
            if (info.name == "cavity")
                info = { info.id, "spine", "bone", mesh::Role::wall }; // bone where the CT shows lung
        datasets::write_label_volume(folder / "in" / "wrong.nrrd", wrong);
        const test_support::CommandRun import = run("--json import " + in("ct.nrrd") + " --labels " + in("wrong.nrrd")
            + " --no-contact-sheet --out " + at("odd/case.json"));
        ASSERT_EQ(import.exit_code, 0);
        ASSERT_EQ(import.json().at("warnings").size(), 1u);
        EXPECT_NE(import.json().at("warnings").at(0).get<std::string>().find("spine"), std::string::npos);
    }

    TEST_F(Import, LabelsOfAnotherPatientAreRefusedUnlessInsistedOn)
    {
        mesh::LabelVolume wrong = phantom.labels;
        for (mesh::LabelInfo& info : wrong.table)
            info = { info.id, info.name, "bone", mesh::Role::wall };
        mesh::Volume air = phantom.ct;
        std::fill(air.voxels.begin(), air.voxels.end(), std::int16_t { -900 });
        datasets::write_label_volume(folder / "in" / "foreign.nrrd", wrong);
        datasets::write_volume(folder / "in" / "air.nrrd", air);
        const std::string import = "--json import " + in("air.nrrd") + " --labels " + in("foreign.nrrd")
            + " --no-contact-sheet --out " + at("foreign/case.json");
        const test_support::CommandRun refused = run(import);
        EXPECT_EQ(refused.exit_code, 2);
        EXPECT_NE(refused.error().find("another patient"), std::string::npos) << refused.out;
        EXPECT_NE(refused.error().find("--accept-labels"), std::string::npos) << refused.out;
        EXPECT_FALSE(fs::exists(folder / "foreign" / "case.json"));
        EXPECT_EQ(run(import + " --accept-labels").exit_code, 0);
    }

    TEST_F(Import, ACaseWithoutAWallIsShownAndNotPlanned)
    {
        mesh::LabelVolume organs = phantom.labels;
        std::erase_if(organs.table, [](const mesh::LabelInfo& info) { return info.role == mesh::Role::wall; });
        for (Label& label : organs.voxels)
            label = mesh::find_label(organs.table, label) == nullptr ? 0 : label;
        datasets::write_label_volume(folder / "in" / "organs.nrrd", organs);
        const std::string case_file = at("crop/case.json");
        const Json imported
            = run("--json import " + in("ct.nrrd") + " --labels " + in("organs.nrrd") + " --out " + case_file).json();
        EXPECT_EQ(imported.at("warnings").size(), 1u);

        const std::string size = " --size 480x320 --out " + at("crop/pictures");
        const test_support::CommandRun render
            = run("--json --profile render " + case_file + " --views slices,overview" + size);
        ASSERT_EQ(render.exit_code, 0);
        ASSERT_EQ(render.json().at("pictures").size(), 2u);
        for (const Json document = render.json(); const Json& picture : document.at("pictures"))
            EXPECT_GT(fs::file_size(picture.at("file").get<std::string>()), 3000u);
        for (const Json document = render.json(); const Json& part : document.at("profile"))
            EXPECT_NE(part.at("part"), "tetrahedra");
        EXPECT_EQ(run("render " + case_file + " --views slices --target 0,40,0,8" + size).exit_code, 0);
        EXPECT_EQ(run("render " + case_file + " --views slices --target nobody" + size).exit_code, 2);

        for (const std::string& command : { "plan " + case_file + " --out " + at("crop/plan"), "mesh " + case_file,
                 "render " + case_file + " --views surgeon" + size }) {
            const test_support::CommandRun refused = run("--json " + command);
            EXPECT_EQ(refused.exit_code, 2) << command;
            EXPECT_NE(
                refused.json().at("error").get<std::string>().find("no label has the role wall"), std::string::npos)
                << command;
        }
    }

    TEST_F(Import, LabelsAreFoundInAChestAndSayHow)
    {
        datasets::ThoraxParameters small;
        small.spacing_mm = { 3.0, 3.0, 3.0 };
        datasets::write_volume(folder / "in" / "chest.nrrd", datasets::make_thorax_phantom(small).ct);
        const test_support::CommandRun import
            = run("--json import " + in("chest.nrrd") + " --autosegment --spacing 3 --out " + at("chest/case.json"));
        ASSERT_EQ(import.exit_code, 0) << import.out;
        const Json document = import.json();
        EXPECT_GT(document.at("structures").size(), 10u);
        bool rough = false;
        for (const Json& structure : document.at("structures")) {
            EXPECT_FALSE(structure.at("how").get<std::string>().empty()) << structure;
            rough = rough || structure.at("rough").get<bool>();
        }
        EXPECT_TRUE(rough); // the skin of a 3 mm grid is no layer that was seen
        std::ifstream written(folder / "chest" / "case.json");
        const Json estimated = Json::parse(written).at("labels").at("estimated");
        EXPECT_NE(std::find(estimated.begin(), estimated.end(), "skin"), estimated.end()) << estimated;
        // A target where no label is: a sphere.
        const test_support::CommandRun add
            = run("approach add " + at("chest/case.json") + " --template median --target 40,-20,60,15");
        EXPECT_EQ(add.exit_code, 0);
    }

} // namespace import_test
} // namespace retractor::ui
