-- The same under its name with a version.

return require('defaultMainScript')
