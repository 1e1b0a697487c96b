#include "datasets/dicom/study_search.h"

#include "datasets/phantoms/phantom.h"
#include "mesh/base/error.h"
#include "tests/datasets/dataset_help.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

namespace retractor::datasets {
namespace study_search_test {

    namespace fs = std::filesystem;

    class StudySearch : public testing::Test {
    protected:
        void SetUp() override
        {
            folder_ = fs::path(testing::TempDir()) / "study_search";
            fs::remove_all(folder_);
            fs::create_directories(folder_);
        }
        fs::path folder_;
    };

    TEST_F(StudySearch, SeriesAreFoundInSubfoldersTheLargestCtFirst)
    {
        BlockParameters small;
        small.size_mm = { 40.0, 80.0, 40.0 };
        small.spacing_mm = { 4.0, 4.0, 4.0 };
        BlockParameters large = small;
        large.size_mm.z() = 80.0;
        fs::create_directories(folder_ / "a");
        fs::create_directories(folder_ / "b" / "deep");
        write_dicom_series(folder_ / "a" / "small", make_block_phantom(small).ct, { .series_description = "small" });
        write_dicom_series(
            folder_ / "b" / "deep" / "large", make_block_phantom(large).ct, { .series_description = "large" });
        std::ofstream(folder_ / "b" / "readme.txt") << "no image";
        fs::create_directory_symlink(folder_, folder_ / "a" / "round"); // a search that followed it would not end
        const std::vector<StudySeries> found = find_study_series(folder_);
        ASSERT_EQ(found.size(), 2U);
        EXPECT_EQ(patients_of(found), 1U) << "both have the phantom's name";
        EXPECT_EQ(found[0].series.description, "large");
        EXPECT_EQ(found[0].path, folder_ / "b" / "deep" / "large");
        EXPECT_EQ(found[1].series.description, "small");
        EXPECT_GT(read_dicom(found[0].middle_file).volume.voxels.size(), 0U);
        EXPECT_EQ(read_dicom(found[0].path, { .series = found[0].series.uid }).volume.grid.size[2],
            static_cast<int>(found[0].series.frames));
    }

    TEST_F(StudySearch, PatientsAreToldApart)
    {
        BlockParameters block;
        block.size_mm = { 40.0, 80.0, 40.0 };
        block.spacing_mm = { 4.0, 4.0, 4.0 };
        const mesh::Volume ct = make_block_phantom(block).ct;
        for (const auto& [folder, id] : { std::pair { "one", "A" }, { "two", "B" }, { "three", "A" } }) {
            fs::create_directories(folder_ / folder);
            write_dicom_series(folder_ / folder / "ct", ct, { .patient_id = id });
        }
        const std::vector<StudySeries> found = find_study_series(folder_);
        ASSERT_EQ(found.size(), 3U);
        EXPECT_EQ(patients_of(found), 2U);
        const auto patient = [&](const char* folder) {
            return std::ranges::find_if(found, [&](const StudySeries& s) {
                return s.path == folder_ / folder / "ct";
            })->patient;
        };
        EXPECT_EQ(patient("one"), patient("three"));
        EXPECT_NE(patient("one"), patient("two"));
    }

    TEST_F(StudySearch, SaysWhereNothingIs)
    {
        EXPECT_THROW((void)find_study_series(folder_ / "none"), IoError);
        try {
            (void)find_study_series(folder_);
            FAIL() << "an empty folder has no series";
        } catch (const InputError& error) {
            EXPECT_NE(std::string(error.what()).find("no DICOM image"), std::string::npos);
        }
    }

    TEST_F(StudySearch, AHospitalsDiscIsSearched)
    {
        const fs::path disc = test_support::shared_data("dicom_objects/dicomdir");
        if (!fs::exists(disc))
            GTEST_SKIP() << "the shared data are not here";
        const std::vector<StudySeries> found = find_study_series(disc);
        EXPECT_GE(found.size(), 4U) << "several patients, modalities and series";
        EXPECT_EQ(found.front().series.modality, "CT");
        EXPECT_TRUE(std::ranges::any_of(found, [](const StudySeries& s) { return s.series.modality != "CT"; }));
        EXPECT_GT(patients_of(found), 1U);
        EXPECT_EQ(found.front().patient, 1U);
    }

} // namespace study_search_test
} // namespace retractor::datasets
