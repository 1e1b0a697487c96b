#include "planner/case/import_case.h"

#include "datasets/dicom/dicom.h"
#include "datasets/io/volume_io.h"
#include "datasets/phantoms/phantom.h"
#include "mesh/base/error.h"
#include "planner/case/case_io.h"
#include "tests/support/synthetic_chest.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdint>

#include <sys/resource.h>

namespace retractor::planner {
namespace import_case_test {

    namespace fs = std::filesystem;

    class ImportCase : public testing::Test {
    protected:
        void SetUp() override
        {
            folder = fs::path(testing::TempDir()) / "import_case"
                / testing::UnitTest::GetInstance()->current_test_info()->name();
            fs::remove_all(folder);
            fs::create_directories(folder);
            datasets::BlockParameters parameters;
            parameters.size_mm = { 40.0, 60.0, 40.0 };
            parameters.target_radius_mm = 6.0;
            phantom = datasets::make_block_phantom(parameters);
            datasets::write_volume(folder / "in.nrrd", phantom.ct);
            datasets::write_label_volume(folder / "in_labels.nrrd", phantom.labels);
            request.ct = folder / "in.nrrd";
            request.labels = { folder / "in_labels.nrrd" };
        }
        fs::path case_file() const { return folder / "case" / "case.json"; }
        fs::path folder;
        datasets::Phantom phantom;
        ImportRequest request;
    };

    std::vector<std::string> names_in(const fs::path& folder)
    {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder))
            names.push_back(entry.path().filename().string());
        std::sort(names.begin(), names.end());
        return names;
    }

    TEST_F(ImportCase, WritesWhatItReadAndNothingElse)
    {
        const ImportedCase imported = read_import(request);
        const Case made = write_import(imported, case_file());
        EXPECT_EQ(names_in(folder / "case"),
            (std::vector<std::string> { "case.json", "ct.nrrd", "labels.labels.json", "labels.nrrd" }));
        const Case read = read_case(case_file()); // checksums verified
        EXPECT_EQ(datasets::read_volume(read.ct_path()).voxels, phantom.ct.voxels);
        EXPECT_EQ(datasets::read_label_volume(read.labels_path()).voxels, phantom.labels.voxels);
        EXPECT_FALSE(read.patient.has_value());
        EXPECT_TRUE(made.supports.labels.empty()); // a block has no spine
    }

    TEST_F(ImportCase, AssumesVesselsOfAChestUntilALabelShowsThem)
    {
        const mesh::LabelVolume chest = test_support::synthetic_chest({});
        datasets::write_label_volume(folder / "in_labels.nrrd", chest);
        request.ct.clear();
        const ImportedCase imported = read_import(request);
        EXPECT_TRUE(std::ranges::any_of(imported.notes,
            [](const std::string& note) { return note.find("assumed where they usually are") != std::string::npos; }));
        Case made = write_import(imported, case_file());
        const auto has = [](const Case& one, const char* name) {
            return std::ranges::find(one.assumed_vessels, name, &AssumedVessel::name) != one.assumed_vessels.end();
        };
        EXPECT_TRUE(has(read_case(case_file()), "mammary_artery_left"));
        EXPECT_TRUE(has(made, "neurovascular_bundle_right_4"));
        // A hand paints the left artery under another of its names.
        mesh::LabelVolume labels = datasets::read_label_volume(made.labels_path());
        labels.table = made.label_table;
        labels.table.push_back({ 900, "internal_thoracic_artery_left", "vessel", mesh::Role::at_risk });
        labels.voxels.front() = 900;
        made = write_corrected_labels(made, labels);
        EXPECT_FALSE(has(made, "mammary_artery_left"));
        EXPECT_TRUE(has(made, "mammary_artery_right"));
    }

    TEST_F(ImportCase, LabelsKeepTheirOwnGrid)
    {
        mesh::LabelVolume coarse = phantom.labels;
        coarse.grid.spacing *= 2.0;
        for (int& n : coarse.grid.size)
            n /= 2;
        coarse = datasets::resample_labels_to(phantom.labels, coarse.grid);
        datasets::write_label_volume(folder / "in_labels.nrrd", coarse);
        const ImportedCase imported = read_import(request);
        EXPECT_EQ(imported.labels->grid.size, coarse.grid.size);
        EXPECT_EQ(imported.ct->grid.size, phantom.ct.grid.size);
    }

    TEST_F(ImportCase, LaterLabelMapsCorrectEarlierOnes)
    {
        mesh::LabelVolume tumour { phantom.labels.grid, std::vector<Label>(phantom.labels.voxels.size(), 0),
            { { 1, "tumour", "soft_tissue", mesh::Role::target } } };
        const std::size_t inside = tumour.grid.offset(12, 20, 12);
        ASSERT_NE(phantom.labels.voxels[inside], 0);
        tumour.voxels[inside] = 1; // an id that the first map gives to something else
        datasets::write_label_volume(folder / "tumour.nrrd", tumour);
        request.labels.push_back(folder / "tumour.nrrd");
        const ImportedCase imported = read_import(request);
        ASSERT_NE(mesh::find_label(imported.labels->table, "tumour"), nullptr);
        EXPECT_EQ(mesh::find_label(imported.labels->table, imported.labels->voxels[inside])->name, "tumour");
        std::size_t changed = 0;
        for (std::size_t v = 0; v < phantom.labels.voxels.size(); ++v) {
            const mesh::LabelInfo* before = mesh::find_label(phantom.labels.table, phantom.labels.voxels[v]);
            const mesh::LabelInfo* after = mesh::find_label(imported.labels->table, imported.labels->voxels[v]);
            changed += (before == nullptr ? "" : before->name) != (after == nullptr ? "" : after->name) ? 1 : 0;
        }
        EXPECT_EQ(changed, 1u);
    }

    TEST_F(ImportCase, ACaseThatIsReplacedKeepsItsImages)
    {
        write_import(read_import(request), case_file());
        const std::string labels_before = checksum(folder / "case" / "labels.nrrd");
        write_import(read_import(request), case_file()); // the same again: nothing new
        EXPECT_EQ(names_in(folder / "case").size(), 4u);
        mesh::LabelVolume changed = phantom.labels;
        changed.voxels[changed.grid.offset(12, 20, 12)] = 1;
        datasets::write_label_volume(folder / "in_labels.nrrd", changed);
        const Case second = write_import(read_import(request), case_file());
        EXPECT_EQ(second.labels.path, "labels-2.nrrd");
        EXPECT_EQ(checksum(folder / "case" / "labels.nrrd"), labels_before);
        EXPECT_NO_THROW(read_case(case_file()));
    }

    TEST_F(ImportCase, CorrectedLabelsAreWrittenBesideThoseBefore)
    {
        Case planned_case = write_import(read_import(request), case_file());
        mesh::LabelVolume labels = datasets::read_label_volume(planned_case.labels_path());
        labels.table = planned_case.label_table;
        labels.voxels.front() = labels.table.back().id;
        const Case corrected = write_corrected_labels(planned_case, labels);
        EXPECT_EQ(corrected.labels.path, "labels-2.nrrd");
        EXPECT_EQ(datasets::read_label_volume(corrected.labels_path()).voxels, labels.voxels);
        EXPECT_TRUE(fs::exists(planned_case.labels_path()));
        EXPECT_EQ(read_case(case_file()).labels.path, "labels-2.nrrd");
        // What contradicts the case is refused, and the case on disk stays.
        labels.table.erase(std::ranges::find(labels.table, "target", &mesh::LabelInfo::name));
        Case with_support = corrected;
        with_support.estimated_labels = { "target" };
        EXPECT_THROW(write_corrected_labels(with_support, labels), InputError);
        EXPECT_EQ(read_case(case_file()).labels.path, "labels-2.nrrd");
        EXPECT_EQ(names_in(folder / "case"),
            (std::vector<std::string> { "case.json", "ct.nrrd", "labels-2.labels.json", "labels-2.nrrd",
                "labels.labels.json", "labels.nrrd" }));
    }

    TEST_F(ImportCase, ImagesInMetresAreRefusedUnlessTheyAreAccepted)
    {
        phantom.ct.grid.spacing *= 1e-3;
        phantom.labels.grid.spacing *= 1e-3;
        phantom.ct.grid.origin *= 1e-3;
        phantom.labels.grid.origin *= 1e-3;
        datasets::write_volume(folder / "in.nrrd", phantom.ct);
        datasets::write_label_volume(folder / "in_labels.nrrd", phantom.labels);
        try {
            (void)read_import(request);
            FAIL() << "an image of 0.06 mm was accepted";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("is it in m ("), std::string::npos) << error.what();
            EXPECT_EQ(error.where(), "CT");
            EXPECT_EQ(error.fields(), std::vector<std::string> { "accept_implausible" });
        }
        request.accept_implausible = true;
        const ImportedCase imported = read_import(request);
        EXPECT_EQ(std::count_if(imported.warnings.begin(), imported.warnings.end(),
                      [](const std::string& text) { return text.find("is it in m (") != std::string::npos; }),
            2)
            << "the CT and the labels";
        EXPECT_TRUE(write_import(imported, case_file()).accept_implausible);
        EXPECT_TRUE(read_case(case_file()).accept_implausible);
    }

    TEST_F(ImportCase, CancelledItLeavesNothing)
    {
        std::atomic<bool> cancel { false };
        Job job;
        job.cancel = &cancel;
        job.on_progress = [&](std::string_view, double) { cancel = true; };
        const ImportedCase imported = read_import(request, job);
        EXPECT_TRUE(imported.cancelled);
        EXPECT_THROW(write_import(imported, case_file()), InputError);
        EXPECT_FALSE(fs::exists(folder / "case"));
    }

    /// While it lives, this process writes no file beyond a size: a full disk, as far as one file meets it.
    class FilesAtMost {
    public:
        explicit FilesAtMost(std::uintmax_t bytes)
        {
            ::getrlimit(RLIMIT_FSIZE, &before_);
            rlimit limit = before_;
            limit.rlim_cur = bytes;
            ::setrlimit(RLIMIT_FSIZE, &limit);
            handler_ = std::signal(SIGXFSZ, SIG_IGN);
        }
        FilesAtMost(const FilesAtMost&) = delete;
        FilesAtMost& operator=(const FilesAtMost&) = delete;
        ~FilesAtMost()
        {
            ::setrlimit(RLIMIT_FSIZE, &before_);
            std::signal(SIGXFSZ, handler_);
        }

    private:
        rlimit before_ {};
        void (*handler_)(int) = SIG_DFL;
    };

    TEST_F(ImportCase, AFullDiskLeavesTheFolderAsItWas)
    {
        for (std::size_t v = 0; v < phantom.ct.voxels.size(); ++v) // so that compression leaves more than of the labels
            phantom.ct.voxels[v] = static_cast<std::int16_t>(v * v % 1009);
        datasets::write_volume(request.ct, phantom.ct);
        request.accept_labels = true;
        const ImportedCase imported = read_import(request);
        write_import(imported, case_file());
        const std::uintmax_t labels = fs::file_size(folder / "case" / "labels.nrrd"),
                             ct = fs::file_size(folder / "case" / "ct.nrrd");
        ASSERT_LT(2 * labels, ct);
        fs::remove_all(folder / "case");
        {
            const FilesAtMost full((labels + ct) / 2);
            try {
                write_import(imported, case_file());
                ADD_FAILURE() << "the CT was written";
            } catch (const IoError& error) {
                EXPECT_EQ(error.where(), (folder / "case" / "ct.nrrd").string());
            }
        }
        EXPECT_EQ(names_in(folder / "case"), std::vector<std::string> {});
        // The images are in place when the case cannot be written: no file name may be that long.
        EXPECT_THROW(write_import(imported, folder / "case" / (std::string(300, 'c') + ".json")), IoError);
        EXPECT_EQ(names_in(folder / "case"), std::vector<std::string> {});
    }

    TEST_F(ImportCase, AKilledImportsFilesAreRemovedByTheNext)
    {
        constexpr const char* kDead = ".retractor-import-2147483646"; // beyond the largest process id
        fs::create_directories(folder / "case" / kDead);
        write_import(read_import(request), case_file());
        EXPECT_FALSE(fs::exists(folder / "case" / kDead));
    }

    TEST_F(ImportCase, TheSpineMayBeLabelledByVertebrae)
    {
        mesh::LabelVolume labels = phantom.labels;
        for (mesh::LabelInfo& info : labels.table)
            if (info.name == "muscle")
                info = { info.id, "vertebrae_T7", "bone", mesh::Role::wall };
        datasets::write_label_volume(folder / "in_labels.nrrd", labels);
        const Case made = write_import(read_import(request), case_file());
        EXPECT_EQ(made.supports.labels, std::vector<std::string> { "vertebrae_T7" });
    }

    TEST_F(ImportCase, ThePatientIsReadBackOnlyWhole)
    {
        Case made = write_import(read_import(request), case_file());
        made.patient = datasets::PatientIdentity { "Musterfrau^Erika", "4711" };
        const Case read = case_from_json(case_to_json(made), made.folder);
        ASSERT_TRUE(read.patient.has_value());
        EXPECT_EQ(read.patient->name, "Musterfrau^Erika");
        EXPECT_EQ(read.patient->id, "4711");
        std::string text = case_to_json(made);
        text.replace(text.find("\"id\": \"4711\""), 4, "\"ix\"");
        EXPECT_THROW(static_cast<void>(case_from_json(text, made.folder)), InputError);
    }

    TEST_F(ImportCase, ErrorsDoNotNameThePatient)
    {
        const fs::path ct = folder / "ct";
        datasets::DicomOptions options;
        options.patient_name = "Doe^John";
        options.patient_id = "4711";
        datasets::write_dicom_series(ct, phantom.ct, options);
        const fs::path named = ct / "DOE_JOHN_4711_0002.dcm";
        fs::rename(ct / "IM0002.dcm", named);
        fs::resize_file(named, fs::file_size(named) - 100);
        request.ct = ct;
        try {
            static_cast<void>(read_import(request));
            ADD_FAILURE() << "not refused";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("truncated"), std::string::npos) << error.what();
            EXPECT_TRUE(error.where().starts_with((ct / "[withheld]_[withheld]_[withheld]_0002.dcm").string()))
                << error.where();
        }
    }

    TEST_F(ImportCase, LabelsFarAwayAreRefused)
    {
        mesh::LabelVolume far = phantom.labels;
        const double wrapped = 4294967296.0; // voxels: an index that comes back to 0 when it is cut to 32 bits
        far.grid.origin.x() += wrapped * phantom.ct.grid.spacing.x();
        datasets::write_label_volume(folder / "in_labels.nrrd", far);
        EXPECT_THROW(static_cast<void>(read_import(request)), InputError);
    }

} // namespace import_case_test
} // namespace retractor::planner
