#pragma once
// What tests tell the stand-in for OpenHaptics: C functions that the real library has not.

extern "C" {
/// Everything back to two healthy devices at rest: "Default Device" (serial 100-1) and "Left Device" (serial 100-2).
void stand_in_reset();
/// Runs the scheduler's callbacks `ticks` times on this thread; only when stand_in_threaded(0).
void stand_in_run(int ticks);
/// 1 (default): the scheduler has its own thread at its rate.
void stand_in_threaded(int own_thread);
/// Where the hand on a device means to be, mm.
void stand_in_target(int device, double x, double y, double z);
void stand_in_buttons(int device, int buttons);
/// Posts an error for a device; 0 devices: for none.
void stand_in_post_error(int device, unsigned code, int internal);
/// From now on every frame of the device fails with a communication error.
void stand_in_unplug(int device);
/// Adds to the encoder's answer, once.
void stand_in_offset(int device, double x, double y, double z);
/// hdInitDevice fails with this error until it is 0.
void stand_in_refuse(unsigned code);
/// 0 calibrated, 1 needs an update, 2 needs the inkwell, 3 needs an update that never helps.
void stand_in_calibration(int device, int state);
/// Noise of the encoders before they round, mm.
void stand_in_noise(double rms_mm);
/// Force at the motors now (saturated, late), N; true position, mm.
void stand_in_motor_force(int device, double* force);
void stand_in_position(int device, double* position);
/// Uses that the real library punishes, as text, one a line; empty when there were none.
const char* stand_in_violations();
int stand_in_initialised(int device);
int stand_in_scheduler_runs();
/// How often it has called, since the reset.
long stand_in_ticks();
}
