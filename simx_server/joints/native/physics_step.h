/* What _physics_step.c offers to _crew.c: functions in a capsule, since each of them is a module of its own.

   Both modules are built from this file; the build writes its hash into both, so an old one is never used with a new
   one. */

#ifndef SIMX_PHYSICS_STEP_H_
#define SIMX_PHYSICS_STEP_H_

#include <Python.h>
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
  int columns;
  int position_target, spring_target, mean_force; /* three of the columns */
} PhysicsStepApi;

#endif
