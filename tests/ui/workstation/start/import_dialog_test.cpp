// A study is imported in the window: series, labels, refusals, the case that comes of it.

#include "tests/support/window/window_help.h"

#include "datasets/dicom/dicom.h"
#include "datasets/io/volume_io.h"
#include "datasets/phantoms/phantom.h"
#include "ui/workstation/main_window.h"
#include "ui/workstation/start/import_dialog.h"

#include <gtest/gtest.h>

#include <QApplication>
#include <QCheckBox>
#include <QFocusEvent>
#include <QLineEdit>
#include <QListWidget>
#include <QPlainTextEdit>
#include <QPushButton>
#include <QTest>

#include <filesystem>
#include <fstream>

namespace retractor::ui {
namespace import_dialog_test {

    namespace fs = std::filesystem;

    class ImportDialogTest : public testing::Test {
    protected:
        static void SetUpTestSuite()
        {
            study_ = fs::path(testing::TempDir()) / "import_dialog";
            fs::remove_all(study_);
            const datasets::Phantom phantom = datasets::make_block_phantom({});
            fs::create_directories(study_ / "disc" / "images");
            datasets::write_dicom_series(study_ / "disc" / "images" / "ct", phantom.ct);
            datasets::write_label_volume(study_ / "labels.nrrd", phantom.labels);
        }
        void SetUp() override
        {
            dialog_.on_imported = [this](const fs::path& file) { opened_ = file; };
            dialog_.show();
        }
        void wait()
        {
            ASSERT_TRUE(QTest::qWaitFor([&] { return dialog_.idle(); }, test_support::kPatienceMs));
        }
        QListWidget& images() { return *dialog_.findChildren<QListWidget*>().front(); }
        void click(const char* name) { QTest::mouseClick(dialog_.findChild<QPushButton*>(name), Qt::LeftButton); }

        static inline fs::path study_;
        fs::path opened_;
        ImportDialog dialog_ { nullptr };
    };

    TEST_F(ImportDialogTest, AStudyAndItsLabelsBecomeACase)
    {
        dialog_.set_study(study_ / "disc");
        wait();
        ASSERT_EQ(images().count(), 1) << dialog_.failure().toStdString();
        EXPECT_TRUE(images().item(0)->text().contains("axial")) << images().item(0)->text().toStdString();
        EXPECT_FALSE(images().item(0)->icon().isNull());
        dialog_.add_labels(study_ / "labels.nrrd");
        EXPECT_FALSE(dialog_.findChild<QCheckBox*>("find labels")->isChecked());
        dialog_.set_case_folder(study_ / "case");
        click("import");
        wait();
        EXPECT_EQ(dialog_.failure(), "");
        EXPECT_TRUE(fs::exists(study_ / "case" / "case.json"));
        EXPECT_TRUE(dialog_.findChild<QPlainTextEdit*>()->toPlainText().contains("The case was written to"));
        click("open");
        EXPECT_EQ(opened_, study_ / "case" / "case.json");
    }

    TEST_F(ImportDialogTest, APathIsReadWhenItsFieldIsLeftAndOnlyOnce)
    {
        auto* path = dialog_.findChild<QLineEdit*>("study");
        const auto leave = [&] { // as Tab does in an active window, which not every display makes of a dialog
            QFocusEvent left(QEvent::FocusOut, Qt::TabFocusReason);
            QApplication::sendEvent(path, &left);
        };
        QTest::keyClicks(path, QString::fromStdString((study_ / "disc").string()));
        leave();
        EXPECT_FALSE(dialog_.idle());
        wait();
        EXPECT_EQ(images().count(), 1) << dialog_.failure().toStdString();
        leave();
        EXPECT_TRUE(dialog_.idle()) << "the same path is not read again";
        path->setText(QString::fromStdString((study_ / "labels.nrrd").string()));
        dialog_.set_case_folder(study_ / "not_imported");
        click("import");
        wait();
        EXPECT_FALSE(fs::exists(study_ / "not_imported")) << "the typed path is another study, which is read first";
    }

    TEST_F(ImportDialogTest, RefusalsSayWhyAndLeaveTheDialogUsable)
    {
        dialog_.set_study(study_ / "nowhere");
        wait();
        EXPECT_TRUE(dialog_.failure().contains("no such file")) << dialog_.failure().toStdString();
        EXPECT_FALSE(dialog_.findChild<QPushButton*>("import")->isEnabled());
        fs::create_directories(study_ / "empty");
        dialog_.set_study(study_ / "empty");
        wait();
        EXPECT_TRUE(dialog_.failure().contains("no DICOM image")) << dialog_.failure().toStdString();
        dialog_.add_labels(study_ / "labels.nrrd");
        EXPECT_FALSE(dialog_.findChild<QPushButton*>("import")->isEnabled()) << "the named study is missing";
        std::ofstream(study_ / "damaged.zip") << "PK\3\4 and then nothing that makes sense";
        dialog_.set_study(study_ / "damaged.zip");
        wait();
        EXPECT_NE(dialog_.failure(), "");

        dialog_.set_study(study_ / "disc");
        wait();
        EXPECT_EQ(dialog_.failure(), "");
        fs::create_directories(study_ / "taken");
        std::ofstream(study_ / "taken" / "case.json") << "{}";
        dialog_.set_case_folder(study_ / "taken");
        click("import");
        wait();
        EXPECT_TRUE(dialog_.failure().contains("already")) << dialog_.failure().toStdString();
        EXPECT_EQ(fs::file_size(study_ / "taken" / "case.json"), 2U) << "what was there is untouched";
    }

    TEST_F(ImportDialogTest, AnImageFileIsAStudyToo)
    {
        datasets::write_volume(study_ / "ct.nrrd", datasets::make_block_phantom({}).ct);
        dialog_.set_study(study_ / "ct.nrrd");
        wait();
        ASSERT_EQ(images().count(), 1) << dialog_.failure().toStdString();
        EXPECT_TRUE(images().item(0)->text().contains("ct.nrrd"));
    }

    TEST(SlicePicture, BlackIsBelowTheWindowAndTheLeftIsAtTheRight)
    {
        mesh::Volume volume;
        volume.grid.size = { 4, 2, 1 };
        volume.grid.spacing = { 1.0, 2.0, 1.0 };
        volume.voxels = { -1000, -1000, -1000, 1000, -1000, -1000, -1000, 1000 };
        const QImage picture = slice_picture(volume, 0);
        EXPECT_EQ(picture.size(), QSize(4, 4)) << "square pixels";
        EXPECT_EQ(qGray(picture.pixel(0, 0)), 0);
        EXPECT_EQ(qGray(picture.pixel(3, 0)), 255);
        volume.grid.direction = Mat3(Vec3(-1.0, 1.0, -1.0).asDiagonal()); // the first axis to the right
        EXPECT_EQ(qGray(slice_picture(volume, 0).pixel(0, 0)), 255);
    }

    TEST(TimeLeft, IsToldOnceThereIsSomethingToTellItBy)
    {
        EXPECT_EQ(time_left(1.0, 0.5), "");
        EXPECT_EQ(time_left(10.0, 0.01), "");
        EXPECT_EQ(time_left(10.0, 0.5), "about 10 s left in this step");
        EXPECT_EQ(time_left(60.0, 0.25), "about 3 min left in this step");
    }

} // namespace import_dialog_test
} // namespace retractor::ui
