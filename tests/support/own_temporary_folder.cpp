// Gives each test program a temporary folder of its own, because tests run in parallel and could otherwise read each
// other's files of the same name. This source is linked into every test program; programs that a test runs inherit the
// folder.

#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <string>
#include <system_error>

namespace retractor::test_support::own_temporary_folder {
namespace {

    class OwnTemporaryFolder : public testing::Environment {
    public:
        void SetUp() override
        {
            path_ = (around_ / "retractor-tests-XXXXXX").string();
            ASSERT_NE(::mkdtemp(path_.data()), nullptr) << path_;
            ::setenv("TMPDIR", path_.c_str(), 1); // std::filesystem::temp_directory_path
            ::setenv("TEST_TMPDIR", path_.c_str(), 1); // testing::TempDir
        }
        void TearDown() override
        {
            if (testing::UnitTest::GetInstance()->Failed()) {
                std::cout << "the files of these tests are kept in " << path_ << '\n';
                return;
            }
            std::error_code ignored;
            std::filesystem::remove_all(path_, ignored);
        }

    private:
        const std::filesystem::path around_ = std::filesystem::temp_directory_path(); ///< also when tests are repeated
        std::string path_;
    };

    [[maybe_unused]] const testing::Environment* const folder
        = testing::AddGlobalTestEnvironment(new OwnTemporaryFolder);

} // namespace
} // namespace retractor::test_support::own_temporary_folder
