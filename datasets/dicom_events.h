#pragma once
// Errors of VTK objects. VTK reports them as events; without an observer it prints them.

#include <vtkCallbackCommand.h>
#include <vtkNew.h>
#include <vtkObject.h>

#include <string>

namespace retractor {

class ErrorCollector {
public:
    explicit ErrorCollector(vtkObject* object)
    {
        command_->SetClientData(this);
        command_->SetCallback([](vtkObject*, unsigned long, void* self, void* text) {
            static_cast<ErrorCollector*>(self)->text_ += text != nullptr ? static_cast<const char*>(text) : "error";
        });
        object->AddObserver(vtkCommand::ErrorEvent, command_);
        object->AddObserver(vtkCommand::WarningEvent, ignore_);
    }
    ErrorCollector(const ErrorCollector&) = delete;
    ErrorCollector& operator=(const ErrorCollector&) = delete;
    bool failed() const { return !text_.empty(); }
    const std::string& text() const { return text_; }

private:
    vtkNew<vtkCallbackCommand> command_;
    vtkNew<vtkCallbackCommand> ignore_;
    std::string text_;
};

} // namespace retractor
