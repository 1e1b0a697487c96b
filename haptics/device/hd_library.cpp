#include "haptics/device/hd_library.h"

#include "mesh/base/error.h"

#include <dlfcn.h>

#include <cstdlib>

namespace retractor::haptics {

namespace {

    template <class Function> bool resolve(void* library, const char* name, Function& function)
    {
        function = reinterpret_cast<Function>(::dlsym(library, name));
        return function != nullptr;
    }

    /// @return name of the first missing function; nullptr when all exist
    const char* resolve_all(void* library, hd::Functions& f)
    {
#define RETRACTOR_RESOLVE(function)                                                                                    \
    if (!resolve(library, #function, f.function))                                                                      \
        return #function;
        RETRACTOR_RESOLVE(hdInitDevice)
        RETRACTOR_RESOLVE(hdDisableDevice)
        RETRACTOR_RESOLVE(hdMakeCurrentDevice)
        RETRACTOR_RESOLVE(hdBeginFrame)
        RETRACTOR_RESOLVE(hdEndFrame)
        RETRACTOR_RESOLVE(hdGetError)
        RETRACTOR_RESOLVE(hdGetErrorString)
        RETRACTOR_RESOLVE(hdEnable)
        RETRACTOR_RESOLVE(hdDisable)
        RETRACTOR_RESOLVE(hdGetIntegerv)
        RETRACTOR_RESOLVE(hdGetDoublev)
        RETRACTOR_RESOLVE(hdGetString)
        RETRACTOR_RESOLVE(hdSetDoublev)
        RETRACTOR_RESOLVE(hdCheckCalibration)
        RETRACTOR_RESOLVE(hdCheckCalibrationStyle)
        RETRACTOR_RESOLVE(hdUpdateCalibration)
        RETRACTOR_RESOLVE(hdStartScheduler)
        RETRACTOR_RESOLVE(hdStopScheduler)
        RETRACTOR_RESOLVE(hdSetSchedulerRate)
        RETRACTOR_RESOLVE(hdScheduleAsynchronous)
        RETRACTOR_RESOLVE(hdUnschedule)
        RETRACTOR_RESOLVE(hdWaitForCompletion)
#undef RETRACTOR_RESOLVE
        return nullptr;
    }

    std::string linker_message()
    {
        const char* const message = ::dlerror();
        return message != nullptr ? message : "it cannot be loaded";
    }

} // namespace

std::vector<std::string> default_hd_libraries()
{
    if (const char* const own = std::getenv("RETRACTOR_HD_LIBRARY"); own != nullptr && *own != '\0')
        return { own };
    return { "libHD.so.3.4", "libHD.so", "libHD.so.3.0" };
}

std::string HdLibrary::load(const std::string& name)
{
    // Global symbols, because the vendor's libraries look for each other's symbols.
    void* const library = ::dlopen(name.c_str(), RTLD_LAZY | RTLD_GLOBAL);
    if (library == nullptr)
        return linker_message();
    if (const char* const missing = resolve_all(library, functions_); missing != nullptr) {
        ::dlclose(library);
        return name + " has no " + missing;
    }
    library_ = library;
    name_ = name;
    return {};
}

HdLibrary::HdLibrary(const std::vector<std::string>& names)
{
    for (const std::string& name : names) {
        const std::string reason = load(name);
        if (reason.empty())
            return;
        attempts_.push_back({ name, reason });
    }
    std::string all;
    for (const HdAttempt& attempt : attempts_)
        all += (all.empty() ? "" : "; ") + attempt.reason;
    throw IoError("OpenHaptics cannot be loaded: " + all, names.empty() ? "" : names.front());
}

HdLibrary::~HdLibrary()
{
    if (library_ != nullptr)
        ::dlclose(library_);
}

std::string missing_library(const std::string& reason)
{
    // Format of glibc: "libX.so.1: cannot open shared object file: No such file or directory".
    const std::size_t end = reason.find(": cannot open shared object file");
    return end == std::string::npos ? std::string() : reason.substr(0, end);
}

} // namespace retractor::haptics
