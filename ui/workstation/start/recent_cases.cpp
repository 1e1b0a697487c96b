#include "ui/workstation/start/recent_cases.h"

#include <QCryptographicHash>
#include <QDir>
#include <QFileInfo>
#include <QSettings>
#include <QStandardPaths>

namespace retractor::ui {

namespace {

    constexpr int kMostCases = 12;
    constexpr QSize kPictureSize { 240, 180 };

    QSettings settings() { return QSettings("Retractor", "retractor-workstation"); }

    QString whole_path(const std::filesystem::path& file)
    {
        return QFileInfo(QString::fromStdString(file.string())).absoluteFilePath();
    }

    QString picture_file(const QString& case_file)
    {
        const QByteArray name = QCryptographicHash::hash(case_file.toUtf8(), QCryptographicHash::Sha1).toHex();
        return QStandardPaths::writableLocation(QStandardPaths::GenericCacheLocation) + "/retractor-workstation/cases/"
            + QString::fromLatin1(name) + ".png";
    }

    void write(const std::vector<RecentCase>& cases)
    {
        QSettings kept = settings();
        kept.beginWriteArray("recent", static_cast<int>(cases.size()));
        for (std::size_t n = 0; n < cases.size(); ++n) {
            kept.setArrayIndex(static_cast<int>(n));
            kept.setValue("file", whole_path(cases[n].file));
            kept.setValue("opened", cases[n].opened);
        }
        kept.endArray();
    }

    /// As they are in the settings, without pictures.
    std::vector<RecentCase> kept_cases()
    {
        std::vector<RecentCase> cases;
        QSettings kept = settings();
        const int count = kept.beginReadArray("recent");
        for (int n = 0; n < count; ++n) {
            kept.setArrayIndex(n);
            cases.push_back({ kept.value("file").toString().toStdString(), kept.value("opened").toDateTime(), {} });
        }
        kept.endArray();
        return cases;
    }

} // namespace

std::vector<RecentCase> recent_cases()
{
    std::vector<RecentCase> cases = kept_cases();
    std::erase_if(cases, [](const RecentCase& recent) { return !QFileInfo::exists(whole_path(recent.file)); });
    for (RecentCase& recent : cases)
        recent.picture = QImage(picture_file(whole_path(recent.file)), "PNG");
    return cases;
}

void remember_case(const std::filesystem::path& file)
{
    std::vector<RecentCase> cases = kept_cases(); // with those on a drive that is not there now
    std::erase_if(cases, [&](const RecentCase& other) { return whole_path(other.file) == whole_path(file); });
    cases.insert(cases.begin(), { file, QDateTime::currentDateTime(), {} });
    if (cases.size() > kMostCases)
        cases.resize(kMostCases);
    write(cases);
}

void keep_case_picture(const std::filesystem::path& file, const QImage& picture)
{
    const QString path = picture_file(whole_path(file));
    QDir().mkpath(QFileInfo(path).path());
    // The middle of the picture, where the patient is.
    const QSize wanted = kPictureSize.scaled(picture.size(), Qt::KeepAspectRatio);
    const QRect middle(
        QPoint((picture.width() - wanted.width()) / 2, (picture.height() - wanted.height()) / 2), wanted);
    picture.copy(middle).scaled(kPictureSize, Qt::KeepAspectRatio, Qt::SmoothTransformation).save(path, "PNG");
}

} // namespace retractor::ui
