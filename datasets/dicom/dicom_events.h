#pragma once
// Collects errors of VTK objects. VTK reports errors as events and prints them when no observer listens.

#include <memory>
#include <string>

class vtkObject;

namespace retractor::datasets {

/// Collects the errors that a VTK object reports during the collector's life. Warnings are dropped.
class ErrorCollector {
public:
    explicit ErrorCollector(vtkObject* object);
    ~ErrorCollector();
    bool failed() const; ///< true after the first error
    const std::string& text() const; ///< the messages of all errors

private:
    struct Observer;
    std::unique_ptr<Observer> observer_;
};

} // namespace retractor::datasets
