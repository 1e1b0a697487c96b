#include "mesh/base/vtk_errors.h"

#include "mesh/base/error.h"

#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <mutex>
#include <thread>
#include <vector>

namespace retractor {

struct VtkErrorTrap::State {
    const std::thread::id thread = std::this_thread::get_id();
    std::string errors {};
};

namespace {

    /// Receives the messages of all threads and hands each to the newest trap of its thread; a message from a thread
    /// without a trap goes to the oldest trap of all. It is VTK's output window while there is a trap.
    class CollectingWindow : public vtkOutputWindow {
    public:
        static CollectingWindow* New();
        vtkTypeMacro(CollectingWindow, vtkOutputWindow)

            void DisplayErrorText(const char* text) override;
        void DisplayText(const char*) override { }
        void DisplayWarningText(const char*) override { }
        void DisplayGenericWarningText(const char*) override { }
        void DisplayDebugText(const char*) override { }
    };

    vtkStandardNewMacro(CollectingWindow)

        struct Traps {
        std::mutex mutex;
        std::vector<VtkErrorTrap::State*> oldest_first;
        vtkSmartPointer<vtkOutputWindow> window_before;
        vtkLogger::Verbosity log_before
            = vtkLogger::VERBOSITY_OFF; ///< VTK's log would repeat every error on standard error
    };

    Traps& traps()
    {
        static Traps all;
        return all;
    }

    void CollectingWindow::DisplayErrorText(const char* text)
    {
        Traps& all = traps();
        const std::lock_guard lock(all.mutex);
        if (all.oldest_first.empty())
            return;
        const auto of_thread = std::find_if(all.oldest_first.rbegin(), all.oldest_first.rend(),
            [](const VtkErrorTrap::State* state) { return state->thread == std::this_thread::get_id(); });
        (of_thread == all.oldest_first.rend() ? all.oldest_first.front() : *of_thread)->errors += text;
    }

} // namespace

VtkErrorTrap::VtkErrorTrap()
    : state_(new State)
{
    Traps& all = traps();
    const std::lock_guard lock(all.mutex);
    if (all.oldest_first.empty()) {
        all.window_before = vtkOutputWindow::GetInstance();
        vtkOutputWindow::SetInstance(vtkSmartPointer<CollectingWindow>::New());
        all.log_before = vtkLogger::GetCurrentVerbosityCutoff();
        vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
    }
    all.oldest_first.push_back(state_);
}

VtkErrorTrap::~VtkErrorTrap()
{
    Traps& all = traps();
    const std::lock_guard lock(all.mutex);
    std::erase(all.oldest_first, state_);
    if (all.oldest_first.empty()) {
        vtkLogger::SetStderrVerbosity(all.log_before);
        vtkOutputWindow::SetInstance(all.window_before);
        all.window_before = nullptr;
    }
    delete state_;
}

std::string VtkErrorTrap::errors() const
{
    const std::lock_guard lock(traps().mutex);
    std::string line = state_->errors;
    std::replace(line.begin(), line.end(), '\n', ' ');
    return line;
}

void VtkErrorTrap::throw_if_error(const std::string& doing) const
{
    const std::string text = errors();
    if (!text.empty())
        throw IoError(doing + ": the drawing library reports: " + text, "vtk");
}

} // namespace retractor
