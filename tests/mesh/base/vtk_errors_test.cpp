#include "mesh/base/vtk_errors.h"

#include "mesh/base/error.h"

#include <gtest/gtest.h>

#include <vtkOutputWindow.h>

#include <string>
#include <thread>

namespace retractor {
namespace vtk_errors_test {

    TEST(VtkErrorTrap, TurnsVtkErrorsIntoOneExceptionAndGivesTheOldHandlerBack)
    {
        vtkOutputWindow* before = vtkOutputWindow::GetInstance();
        {
            const VtkErrorTrap trap;
            EXPECT_NO_THROW(trap.throw_if_error("nothing"));
            vtkOutputWindowDisplayErrorText("the shader\nis broken");
            try {
                trap.throw_if_error("drawing");
                FAIL() << "no exception";
            } catch (const IoError& error) {
                EXPECT_STREQ(error.what(), "drawing: the drawing library reports: the shader is broken");
            }
        }
        EXPECT_EQ(vtkOutputWindow::GetInstance(), before);
    }

    TEST(VtkErrorTrap, EachThreadHasItsOwnAndTheOldestTakesTheRest)
    {
        const VtkErrorTrap oldest;
        std::string of_other;
        std::thread([&] {
            const VtkErrorTrap other;
            vtkOutputWindow::GetInstance()->DisplayErrorText("from a thread with a trap");
            of_other = other.errors();
        }).join();
        EXPECT_NE(of_other.find("with a trap"), std::string::npos);
        EXPECT_EQ(oldest.errors(), "");
        std::thread([] { vtkOutputWindow::GetInstance()->DisplayErrorText("from a thread without"); }).join();
        EXPECT_NE(oldest.errors().find("without"), std::string::npos);
    }

} // namespace vtk_errors_test
} // namespace retractor
