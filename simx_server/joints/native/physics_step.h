/* What _physics_step.c offers to _crew.c: functions in a capsule, since each is a separate module; and what both use.

   Both modules are built from this file; the build writes its hash into both, so an old one is never used with a new
   one. */

#ifndef SIMX_PHYSICS_STEP_H_
#define SIMX_PHYSICS_STEP_H_

#include <Python.h>
#include <time.h>

#include <mujoco/mujoco.h>

#define PHYSICS_STEP_API "simx_server.joints.native._physics_step.API"

enum { LIMIT_SEPARATION = 1, KEEP_DOWN = 2, LAST_FORCE = 4, UPDATE = 8 }; /* as in ../stepping/stepper.py */

/* How a run has ended. NO_ROOM: a motor has no constraint; EXCEPTION: of Python, which is set; FAILED: MuJoCo's error. */
enum { WELL, NO_ROOM, EXCEPTION, FAILED };

enum { MOST_WARNINGS = 4, TEXT_SIZE = 1024 };

/* What a run has found. */
typedef struct {
  Py_ssize_t made;
  double seconds;
  char has_diverged, is_finite, has_deep_contacts;
  char problem[TEXT_SIZE];                   /* of a run that FAILED */
  char warnings[MOST_WARNINGS][TEXT_SIZE];   /* of MuJoCo; those beyond these are not kept */
  int warning_count;
} PhysicsReport;

typedef struct {
  /* Make physics steps from number `made` to before `end` of the `count` of a simulation step, at most for `limit`
     seconds. The thread has not the interpreter's lock, but a thread state, which the run may use. */
  int (*run)(PyObject* step, Py_ssize_t made, Py_ssize_t end, Py_ssize_t count, double limit, int flags,
             PyThreadState** thread, PhysicsReport* report);
  mjModel* (*model)(PyObject* step);
  mjData* (*data)(PyObject* step);

  /* The numbers of a column and their count; NULL if the column has indexes, or there is no such column. */
  double* (*numbers)(PyObject* step, int column, Py_ssize_t* count);
  /* Update the kinematics; kinematics.py */
  void (*update)(const mjModel* m, mjData* d);

  int columns;
  int position_target, spring_target, mean_force; /* three of the columns */
} PhysicsStepApi;


//------------------------------------------ in both -----------------------------------------------

static inline double seconds(void) {
  struct timespec now;
#ifdef _WIN32
  timespec_get(&now, TIME_UTC);
#else
  clock_gettime(CLOCK_MONOTONIC, &now);
#endif
  return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

/* min and max of Python: the first one, unless the second is less or greater */
static inline double lesser(double a, double b) { return b < a ? b : a; }
static inline double greater(double a, double b) { return b > a ? b : a; }

/* A function of the loaded MuJoCo, and where its address is kept. */
typedef struct { const char* name; void** place; } Wanted;

/* Keep the addresses of functions; returns -1 with an exception if one is missing. */
static inline int take_addresses(PyObject* addresses, const Wanted* wanted, size_t count) {
  for (size_t i = 0; i < count; i++) {
    PyObject* number = PyDict_GetItemString(addresses, wanted[i].name);
    void* address = number ? PyLong_AsVoidPtr(number) : NULL;
    if (!address) {
      if (!PyErr_Occurred()) {
        PyErr_Format(PyExc_KeyError, "the address of %s is missing", wanted[i].name);
      }
      return -1;
    }
    *wanted[i].place = address;
  }
  return 0;
}

#endif
