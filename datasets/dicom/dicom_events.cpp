#include "datasets/dicom/dicom_events.h"

#include <vtkCallbackCommand.h>
#include <vtkNew.h>
#include <vtkObject.h>

namespace retractor::datasets {

struct ErrorCollector::Observer {
    vtkNew<vtkCallbackCommand> command;
    vtkNew<vtkCallbackCommand> ignore;
    std::string text;
};

ErrorCollector::ErrorCollector(vtkObject* object)
    : observer_(std::make_unique<Observer>())
{
    observer_->command->SetClientData(observer_.get());
    observer_->command->SetCallback([](vtkObject*, unsigned long, void* self, void* text) {
        static_cast<Observer*>(self)->text += text != nullptr ? static_cast<const char*>(text) : "error";
    });
    object->AddObserver(vtkCommand::ErrorEvent, observer_->command);
    object->AddObserver(vtkCommand::WarningEvent, observer_->ignore);
}

ErrorCollector::~ErrorCollector() = default;
bool ErrorCollector::failed() const { return !observer_->text.empty(); }
const std::string& ErrorCollector::text() const { return observer_->text; }

} // namespace retractor::datasets
