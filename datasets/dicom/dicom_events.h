#pragma once
// Errors of VTK objects. VTK reports them as events; without an observer it prints them.

#include <memory>
#include <string>

class vtkObject;

namespace retractor::datasets {

/// Collects what an object reports from now on; warnings are dropped.
class ErrorCollector {
public:
    explicit ErrorCollector(vtkObject* object);
    ~ErrorCollector();
    bool failed() const;
    const std::string& text() const;

private:
    struct Observer;
    std::unique_ptr<Observer> observer_;
};

} // namespace retractor::datasets
