#include "ui/scene/vtk/vtk_errors.h"

#include "mesh/base/error.h"

#include <vtkLogger.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkSmartPointer.h>

#include <algorithm>
#include <mutex>

namespace retractor::ui {

namespace {

    class CollectingWindow : public vtkOutputWindow {
    public:
        static CollectingWindow* New();
        vtkTypeMacro(CollectingWindow, vtkOutputWindow)

            void DisplayErrorText(const char* text) override
        {
            const std::lock_guard lock(mutex_);
            errors_ += text;
        }
        void DisplayText(const char*) override { }
        void DisplayWarningText(const char*) override { }
        void DisplayGenericWarningText(const char*) override { }
        void DisplayDebugText(const char*) override { }

        std::string errors() const
        {
            const std::lock_guard lock(mutex_);
            std::string line = errors_;
            std::replace(line.begin(), line.end(), '\n', ' ');
            return line;
        }

    private:
        mutable std::mutex mutex_;
        std::string errors_;
    };

    vtkStandardNewMacro(CollectingWindow)

} // namespace

struct VtkErrorTrap::State {
    vtkSmartPointer<vtkOutputWindow> before;
    vtkSmartPointer<CollectingWindow> window;
    vtkLogger::Verbosity log_before
        = vtkLogger::VERBOSITY_OFF; ///< VTK's log would repeat every error on standard error
};

VtkErrorTrap::VtkErrorTrap()
    : state_(new State)
{
    state_->before = vtkOutputWindow::GetInstance();
    state_->window = vtkSmartPointer<CollectingWindow>::New();
    vtkOutputWindow::SetInstance(state_->window);
    state_->log_before = vtkLogger::GetCurrentVerbosityCutoff();
    vtkLogger::SetStderrVerbosity(vtkLogger::VERBOSITY_OFF);
}

VtkErrorTrap::~VtkErrorTrap()
{
    vtkLogger::SetStderrVerbosity(state_->log_before);
    vtkOutputWindow::SetInstance(state_->before);
    delete state_;
}

std::string VtkErrorTrap::errors() const { return state_->window->errors(); }

void VtkErrorTrap::throw_if_error(const std::string& doing) const
{
    const std::string text = errors();
    if (!text.empty())
        throw IoError(doing + ": the drawing library reports: " + text, "vtk");
}

} // namespace retractor::ui
