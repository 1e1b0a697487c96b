#pragma once
// What tests tell the simulated OpenHaptics library: C functions that the real library does not have.

extern "C" {
/// Everything back to two healthy devices at rest: "Default Device" (serial 100-1) and "Left Device" (serial 100-2).
void simulated_reset();
/// Runs the scheduler's callbacks `ticks` times on this thread; only when simulated_threaded(0).
void simulated_run(int ticks);
/// 1 (default): the scheduler has its own thread at its rate.
void simulated_threaded(int own_thread);
/// Where the hand on a device means to be, mm.
void simulated_target(int device, double x, double y, double z);
void simulated_buttons(int device, int buttons);
/// Posts an error for a device; 0 devices: for none.
void simulated_post_error(int device, unsigned code, int internal);
/// From now on every frame of the device fails with a communication error.
void simulated_unplug(int device);
/// Adds to the encoder's answer, once.
void simulated_offset(int device, double x, double y, double z);
/// hdInitDevice fails with this error until it is 0.
void simulated_refuse(unsigned code);
/// 0 calibrated, 1 needs an update, 2 needs the inkwell, 3 needs an update that never helps.
void simulated_calibration(int device, int state);
/// Noise of the encoders before they round, mm.
void simulated_noise(double rms_mm);
/// Force at the motors now (saturated, late), N; true position, mm.
void simulated_motor_force(int device, double* force);
void simulated_position(int device, double* position);
/// Uses that the real library punishes, as text, one a line; empty when there were none.
const char* simulated_violations();
int simulated_initialised(int device);
int simulated_scheduler_runs();
/// How often it has called, since the reset.
long simulated_ticks();
}
