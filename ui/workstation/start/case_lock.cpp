#include "ui/workstation/start/case_lock.h"

#include <QLockFile>
#include <QSysInfo>

namespace retractor::ui {

std::filesystem::path CaseLock::file_of(const std::filesystem::path& case_file)
{
    std::filesystem::path lock = case_file;
    lock.replace_extension(".lock");
    return lock;
}

CaseLock::CaseLock(const std::filesystem::path& case_file)
    : file_(std::make_unique<QLockFile>(QString::fromStdString(file_of(case_file).string())))
{
    file_->setStaleLockTime(0); // a window may be open for days
    if (file_->tryLock(0) || file_->error() != QLockFile::LockFailedError)
        return;
    qint64 process = 0;
    QString computer, program;
    const bool is_known = file_->getLockInfo(&process, &computer, &program) && !computer.isEmpty();
    holder_
        = !is_known || computer == QSysInfo::machineHostName() ? "on this computer" : "on " + computer.toStdString();
}

CaseLock::~CaseLock() = default;

} // namespace retractor::ui
