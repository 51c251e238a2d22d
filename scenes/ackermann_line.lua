-- Mounts the camera on the car, where it stands already.

function sysCall_init()
    local camera = sim.getObjectHandle('Vision_sensor')
    sim.setObjectParent(camera, sim.getObjectHandle('nakedAckermannSteeringCar'), true)
end
